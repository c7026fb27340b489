#pragma once

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

/// Triangle meshes as plain arrays, for the programs that remaps is compared with: they load and
/// store files the same, cheap way. Reads just what the bench makes: binary little-endian PLY with
/// float x, y, z and `list uchar int|uint` triangles; all else is refused.
namespace peers {

struct MeshArrays {
  std::vector<float> coordinates;      ///< (3 a vertex)
  std::vector<std::uint32_t> corners;  ///< (3 a triangle)
};

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using FilePointer = std::unique_ptr<std::FILE, FileCloser>;

inline constexpr std::size_t kTriangleBytes = 13;
inline constexpr std::size_t kTrianglesABlock = 65536;

inline FilePointer open_file(const std::string& path, const char* mode) {
  FilePointer file(std::fopen(path.c_str(), mode));
  if (!file) throw std::runtime_error(path + ": " + std::strerror(errno));
  return file;
}

inline std::string header_line(std::FILE* file, const std::string& path) {
  char line[256];
  if (std::fgets(line, sizeof line, file) == nullptr) {
    throw std::runtime_error(path + ": the header ends early");
  }
  std::string text(line);
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return text;
}

/// Sizes the arrays as the header says, and leaves the file at its data.
inline void read_header(std::FILE* file, const std::string& path, MeshArrays& mesh) {
  std::string shape;
  for (std::string line = header_line(file, path); line != "end_header";
       line = header_line(file, path)) {
    unsigned long long count = 0;
    if (line.starts_with("comment")) continue;
    if (std::sscanf(line.c_str(), "element vertex %llu", &count) == 1) {
      mesh.coordinates.resize(3 * count);
      line = "element vertex";
    } else if (std::sscanf(line.c_str(), "element face %llu", &count) == 1) {
      mesh.corners.resize(3 * count);
      line = "element face";
    } else if (line == "property list uchar uint vertex_indices") {
      line = "property list uchar int vertex_indices";
    }
    shape += line + "\n";
  }
  if (shape !=
      "ply\nformat binary_little_endian 1.0\nelement vertex\nproperty float x\nproperty float y\n"
      "property float z\nelement face\nproperty list uchar int vertex_indices\n") {
    throw std::runtime_error(path + ": not a PLY as the bench writes it");
  }
}

inline MeshArrays read_ply(const std::string& path) {
  const FilePointer file = open_file(path, "rb");
  MeshArrays mesh;
  read_header(file.get(), path, mesh);
  const auto read = [&](void* to, std::size_t bytes) {
    if (std::fread(to, 1, bytes, file.get()) != bytes) {
      throw std::runtime_error(path + ": the data end early");
    }
  };
  read(mesh.coordinates.data(), mesh.coordinates.size() * sizeof(float));
  std::vector<unsigned char> block(kTriangleBytes * kTrianglesABlock);
  const std::size_t faces = mesh.corners.size() / 3;
  for (std::size_t begin = 0; begin < faces; begin += kTrianglesABlock) {
    const std::size_t count = std::min(kTrianglesABlock, faces - begin);
    read(block.data(), count * kTriangleBytes);
    for (std::size_t i = 0; i < count; ++i) {
      const unsigned char* record = &block[i * kTriangleBytes];
      if (record[0] != 3) throw std::runtime_error(path + ": a face is no triangle");
      std::memcpy(&mesh.corners[3 * (begin + i)], record + 1, 12);
    }
  }
  return mesh;
}

inline void write_ply(const std::string& path, const MeshArrays& mesh) {
  const FilePointer file = open_file(path, "wb");
  std::fprintf(file.get(),
               "ply\nformat binary_little_endian 1.0\nelement vertex %zu\nproperty float x\n"
               "property float y\nproperty float z\nelement face %zu\n"
               "property list uchar int vertex_indices\nend_header\n",
               mesh.coordinates.size() / 3, mesh.corners.size() / 3);
  std::fwrite(mesh.coordinates.data(), sizeof(float), mesh.coordinates.size(), file.get());
  for (std::size_t i = 0; i < mesh.corners.size(); i += 3) {
    unsigned char record[kTriangleBytes] = {3};
    std::memcpy(record + 1, &mesh.corners[i], 12);
    std::fwrite(record, 1, kTriangleBytes, file.get());
  }
  if (std::fflush(file.get()) != 0 || std::ferror(file.get()) != 0) {
    throw std::runtime_error(path + ": writing failed");
  }
}

}  // namespace peers
