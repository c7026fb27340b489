// write_text_mesh INPUT OUTPUT.{ply,obj,off}: the mesh as text, ASCII PLY, OBJ or OFF, with as many
// digits as a float needs. remaps itself writes no text PLY; the readers are measured on this one.
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "remaps/formats/mesh_reader.h"

namespace {

using namespace remaps;

enum class Form { kPly, kObj, kOff };

Form form_of(const std::filesystem::path& path) {
  if (path.extension() == ".ply") return Form::kPly;
  if (path.extension() == ".obj") return Form::kObj;
  if (path.extension() == ".off") return Form::kOff;
  throw std::runtime_error(path.string() + ": expected .ply, .obj or .off");
}

struct Counts {
  std::uint64_t vertices = 0, faces = 0;
};

Counts count(IndexedMeshReader& reader) {
  Counts n;
  reader.read_positions([&](std::span<const Vec3> chunk) { n.vertices += chunk.size(); });
  reader.read_triangles([&](std::span<const Triangle> chunk) { n.faces += chunk.size(); });
  return n;
}

std::string header(Form form, const Counts& n) {
  switch (form) {
    case Form::kPly:
      return fmt::format(
          "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
          "property float z\nelement face {}\nproperty list uchar int vertex_indices\n"
          "end_header\n",
          n.vertices, n.faces);
    case Form::kObj:
      return "";
    case Form::kOff:
      return fmt::format("OFF\n{} {} 0\n", n.vertices, n.faces);
  }
  return "";
}

class TextFile {
 public:
  explicit TextFile(const std::filesystem::path& path)
      : path_(path), file_(std::fopen(path.c_str(), "wb"), &std::fclose) {
    if (!file_) throw std::runtime_error(path.string() + ": cannot be created");
  }
  void write(std::string_view text) {
    if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) fail();
  }
  void close() {
    if (std::fclose(file_.release()) != 0) fail();
  }

 private:
  [[noreturn]] void fail() const { throw std::runtime_error(path_.string() + ": writing failed"); }

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

void write(const char* input, const std::filesystem::path& output) {
  const Form form = form_of(output);
  const auto reader = open_mesh_reader(input);
  TextFile file(output);
  file.write(header(form, count(*reader)));
  reader->read_positions([&](std::span<const Vec3> chunk) {
    fmt::memory_buffer text;
    for (const Vec3& p : chunk) {
      const Vec3f f = to_float(p);
      fmt::format_to(std::back_inserter(text), "{}{} {} {}\n", form == Form::kObj ? "v " : "", f.x,
                     f.y, f.z);
    }
    file.write({text.data(), text.size()});
  });
  const std::uint64_t first = form == Form::kObj ? 1 : 0;
  reader->read_triangles([&](std::span<const Triangle> chunk) {
    fmt::memory_buffer text;
    for (const Triangle& t : chunk) {
      fmt::format_to(std::back_inserter(text), "{} {} {} {}\n", form == Form::kObj ? "f" : "3",
                     t[0] + first, t[1] + first, t[2] + first);
    }
    file.write({text.data(), text.size()});
  });
  file.close();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: write_text_mesh INPUT OUTPUT.{{ply,obj,off}}\n");
    return 2;
  }
  try {
    write(argv[1], argv[2]);
  } catch (const std::exception& error) {
    fmt::print(stderr, "write_text_mesh: {}\n", error.what());
    return 1;
  }
}
