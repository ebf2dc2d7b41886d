// Hands the bytes of libFuzzer to one target.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "tests/fuzz/target.hpp"

namespace {

/// What this thread has computed, s: libFuzzer's own limit goes by the clock on the wall, and a machine that
/// is busy elsewhere breaks it.
double computed_s() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

constexpr double kMost_s = 5;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const double before_s = computed_s();
  truepose::fuzz::TRUEPOSE_FUZZ_TARGET({reinterpret_cast<const char*>(bytes), size});
  const double took_s = computed_s() - before_s;
  if (took_s > kMost_s) {
    std::fprintf(stderr, "this input took %.1f s of a processor, more than %.0f\n", took_s, kMost_s);
    std::abort();
  }
  return 0;
}
