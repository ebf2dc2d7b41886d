// Hands the bytes of libFuzzer to one target.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  truepose::fuzz::TRUEPOSE_FUZZ_TARGET({reinterpret_cast<const char*>(bytes), size});
  return 0;
}
