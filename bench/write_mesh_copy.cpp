// write_mesh_copy INPUT OUTPUT: the mesh in another format. Text as ASCII PLY, OBJ, OFF or STL,
// with as many digits as a float needs, which remaps itself writes of some only; binary STL if the
// name ends in .binary.stl, and GLB. The readers are measured on these.
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <vector>

#include "remaps/formats/mesh_reader.h"
#include "remaps/formats/mesh_writer.h"

namespace {

using namespace remaps;

enum class Form { kPly, kObj, kOff, kStl };

Form form_of(const std::filesystem::path& path) {
  if (path.extension() == ".ply") return Form::kPly;
  if (path.extension() == ".obj") return Form::kObj;
  if (path.extension() == ".off") return Form::kOff;
  if (path.extension() == ".stl") return Form::kStl;
  throw std::runtime_error(path.string() + ": expected .ply, .obj, .off, .stl or .glb");
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
    case Form::kStl:
      return "solid copy\n";
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

void write_binary(const char* input, const std::filesystem::path& output) {
  const auto reader = open_mesh_reader(input);
  const Counts n = count(*reader);
  const auto writer = open_mesh_writer(output, n.vertices, n.faces);
  reader->read_positions([&](std::span<const Vec3> chunk) { writer->write_positions(chunk); });
  reader->read_triangles([&](std::span<const Triangle> chunk) { writer->write_triangles(chunk); });
  writer->close();
}

void write_stl_text(IndexedMeshReader& reader, TextFile& file) {
  std::vector<Vec3f> position;
  reader.read_positions([&](std::span<const Vec3> chunk) {
    for (const Vec3& p : chunk) position.push_back(to_float(p));
  });
  reader.read_triangles([&](std::span<const Triangle> chunk) {
    fmt::memory_buffer text;
    for (const Triangle& t : chunk) {
      fmt::format_to(std::back_inserter(text), "facet normal 0 0 0\n outer loop\n");
      for (const VertexId v : t) {
        const Vec3f& p = position[v];
        fmt::format_to(std::back_inserter(text), "  vertex {} {} {}\n", p.x, p.y, p.z);
      }
      fmt::format_to(std::back_inserter(text), " endloop\nendfacet\n");
    }
    file.write({text.data(), text.size()});
  });
  file.write("endsolid copy\n");
}

void write_text(const char* input, const std::filesystem::path& output) {
  const Form form = form_of(output);
  const auto reader = open_mesh_reader(input);
  TextFile file(output);
  file.write(header(form, count(*reader)));
  if (form == Form::kStl) {
    write_stl_text(*reader, file);
    file.close();
    return;
  }
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
    fmt::print(stderr, "usage: write_mesh_copy INPUT OUTPUT.{{ply,obj,off,stl,glb}}\n");
    return 2;
  }
  try {
    const std::filesystem::path output = argv[2];
    const bool binary =
        output.extension() == ".glb" || output.filename().string().ends_with(".binary.stl");
    (binary ? write_binary : write_text)(argv[1], output);
  } catch (const std::exception& error) {
    fmt::print(stderr, "write_mesh_copy: {}\n", error.what());
    return 1;
  }
}
