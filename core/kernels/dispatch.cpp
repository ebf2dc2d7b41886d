#include "core/kernels/dispatch.hpp"

#include "core/kernels/table.hpp"

TRUEPOSE_KERNELS_OF(baseline)
#ifdef TRUEPOSE_X86_KERNELS
TRUEPOSE_KERNELS_OF(avx2)
TRUEPOSE_KERNELS_OF(avx512)
#endif

namespace truepose::kernels {

bool available([[maybe_unused]] Isa isa) {
#ifdef TRUEPOSE_X86_KERNELS
  if (isa == Isa::Avx2) return __builtin_cpu_supports("x86-64-v3") != 0;
  if (isa == Isa::Avx512) return __builtin_cpu_supports("x86-64-v4") != 0;
#endif
  return isa == Isa::Baseline;
}

const Kernels& kernels_for([[maybe_unused]] Isa isa) {
#ifdef TRUEPOSE_X86_KERNELS
  if (isa == Isa::Avx2) return avx2::kKernels;
  if (isa == Isa::Avx512) return avx512::kKernels;
#endif
  return baseline::kKernels;
}

namespace {

const Kernels*& chosen() {
  static const Kernels* kernels = &kernels_for(available(Isa::Avx512) ? Isa::Avx512
                                               : available(Isa::Avx2) ? Isa::Avx2
                                                                      : Isa::Baseline);
  return kernels;
}

}  // namespace

const Kernels& best() { return *chosen(); }
void use(Isa isa) { chosen() = &kernels_for(isa); }

}  // namespace truepose::kernels
