// read_mesh FILE: reads a mesh with the library, and says as JSON what each of the two passes took,
// in seconds of the clock and of processors.
#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <exception>

#include "remaps/formats/mesh_reader.h"

namespace {

using namespace remaps;

struct Clock {
  static double wall() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }
  static double cpu() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }
};

struct Pass {
  std::uint64_t elements = 0;
  double seconds = 0, cpu_seconds = 0;

  template <class Work>
  explicit Pass(Work work) {
    const double wall = Clock::wall(), cpu = Clock::cpu();
    elements = work();
    seconds = Clock::wall() - wall;
    cpu_seconds = Clock::cpu() - cpu;
  }

  std::string json() const {
    return fmt::format(R"({{"elements": {}, "seconds": {:.6f}, "cpu_seconds": {:.6f}}})", elements,
                       seconds, cpu_seconds);
  }
};

void read(const char* path) {
  const auto reader = open_mesh_reader(path);
  // Sums that are printed, so that nothing read is thrown away.
  double coordinates = 0;
  std::uint64_t corners = 0;
  const Pass positions([&] {
    std::uint64_t count = 0;
    reader->read_positions([&](std::span<const Vec3> chunk) {
      count += chunk.size();
      for (const Vec3& p : chunk) coordinates += p.x + p.y + p.z;
    });
    return count;
  });
  const Pass triangles([&] {
    std::uint64_t count = 0;
    reader->read_triangles([&](std::span<const Triangle> chunk) {
      count += chunk.size();
      for (const Triangle& t : chunk) corners += t[0] + t[1] + t[2];
    });
    return count;
  });
  fmt::print("{{\"bytes\": {}, \"positions\": {}, \"triangles\": {}, \"sums\": [{:.17g}, {}]}}\n",
             reader->bytes_total(), positions.json(), triangles.json(), coordinates, corners);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: read_mesh FILE\n");
    return 2;
  }
  try {
    read(argv[1]);
  } catch (const std::exception& error) {
    fmt::print(stderr, "read_mesh: {}\n", error.what());
    return 1;
  }
}
