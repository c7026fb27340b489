#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "remaps/base/errors.h"
#include "remaps/formats/mesh_reader.h"

namespace remaps {

/// A mesh as the streams of a reader delivered it.
struct MeshContent {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  bool positions_are_float = false;
};

inline MeshContent read_mesh(const std::filesystem::path& path) {
  MeshContent mesh;
  const auto reader = open_mesh_reader(path);
  reader->read_positions([&](std::span<const Vec3> chunk) {
    mesh.positions.insert(mesh.positions.end(), chunk.begin(), chunk.end());
  });
  reader->read_triangles([&](std::span<const Triangle> chunk) {
    mesh.triangles.insert(mesh.triangles.end(), chunk.begin(), chunk.end());
  });
  mesh.positions_are_float = reader->positions_are_float();
  return mesh;
}

/// Tests that make files: a directory of their own, removed at the end.
class MeshFiles : public testing::Test {
 protected:
  MeshFiles() {
    const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
    directory_ =
        std::filesystem::path(testing::TempDir()) / ("remaps_" + std::to_string(::getpid()) + "_" +
                                                     test->test_suite_name() + "_" + test->name());
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directories(directory_);
  }
  ~MeshFiles() override { std::filesystem::remove_all(directory_); }

  const std::filesystem::path& directory() const { return directory_; }

  std::filesystem::path make_file(std::string_view name, std::string_view bytes) const {
    const std::filesystem::path path = directory_ / name;
    std::ofstream(path, std::ios::binary).write(bytes.data(), std::ssize(bytes));
    return path;
  }
  static std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  MeshContent read_bytes(std::string_view name, std::string_view bytes) const {
    return read_mesh(make_file(name, bytes));
  }
  /// Expects an InputError that names the file and says all of the given things.
  void expect_refused(std::string_view name, std::string_view bytes,
                      std::initializer_list<std::string_view> says = {}) const {
    try {
      read_bytes(name, bytes);
      ADD_FAILURE() << name << " was read";
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find(name), std::string::npos) << message;
      for (const std::string_view part : says) {
        EXPECT_NE(message.find(part), std::string::npos) << message << "\nlacks: " << part;
      }
    }
  }

 private:
  std::filesystem::path directory_;
};

/// Appends values as they lie in a binary file.
template <class T>
void append(std::string& bytes, T value, std::endian order = std::endian::little) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (order != std::endian::native) std::reverse(std::begin(raw), std::end(raw));
  bytes.append(raw, sizeof(T));
}

}  // namespace remaps
