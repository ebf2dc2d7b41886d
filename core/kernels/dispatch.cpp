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

const Kernels& best() {
  static const Kernels& chosen = available(Isa::Avx512) ? kernels_for(Isa::Avx512)
                                 : available(Isa::Avx2) ? kernels_for(Isa::Avx2)
                                                        : kernels_for(Isa::Baseline);
  return chosen;
}

}  // namespace truepose::kernels
