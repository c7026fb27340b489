#include <cstddef>
#include <cstdint>
#include <span>

#include "fuzz_targets.h"

/// What libFuzzer calls; REMAPS_FUZZ_TARGET is the target of this program. What escapes ends the
/// program, which libFuzzer reports as a finding.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  remaps::fuzz::run_target(REMAPS_FUZZ_TARGET, std::as_bytes(std::span(data, size)));
  return 0;
}
