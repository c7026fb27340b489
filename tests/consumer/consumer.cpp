#include <remaps/generate/scan_generator.h>

#include <cstdio>

/// Generates a small mesh with the installed library and checks its Euler characteristic.
int main() {
  remaps::GeneratorOptions options;
  options.vertices = 1000;
  const remaps::ScanGenerator generator(options);
  const auto euler = generator.vertices() - generator.faces() / 2;
  std::printf("%llu vertices, Euler characteristic %llu\n",
              static_cast<unsigned long long>(generator.vertices()),
              static_cast<unsigned long long>(euler));
  return euler == 2 ? 0 : 1;
}
