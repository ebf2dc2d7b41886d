#pragma once

// Vectors of doubles as wide as the instruction set that this source is being compiled for. Everything lives
// in that instruction set's own namespace, and nothing outside it is included, so that the linker cannot
// share a function between machines.

#ifndef TRUEPOSE_KERNEL_ISA
#error "compiled by core/kernels/CMakeLists.txt, once for each instruction set"
#endif

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {

#if defined(__AVX512F__)
inline constexpr int kLanes = 8;
#elif defined(__AVX2__)
inline constexpr int kLanes = 4;
#else
inline constexpr int kLanes = 2;
#endif

using Vec = double __attribute__((vector_size(8 * kLanes)));
using IntVec = long long __attribute__((vector_size(8 * kLanes)));
/// Three coordinates and the homogeneous one.
using Vec4 = double __attribute__((vector_size(32)));

inline Vec load(const double* from) {
  Vec out;
  __builtin_memcpy(&out, from, sizeof out);
  return out;
}
inline Vec4 load4(const double* from) {
  Vec4 out;
  __builtin_memcpy(&out, from, sizeof out);
  return out;
}
inline void store(double* to, Vec value) { __builtin_memcpy(to, &value, sizeof value); }
inline void store4(double* to, Vec4 value) { __builtin_memcpy(to, &value, sizeof value); }

inline Vec all(double value) { return value - Vec{}; }

template <int...>
struct Indices {};
/// Counts down in front of what it has counted: Count<3> is Count<0, 0, 1, 2>.
template <int kLeft, int... kCounted>
struct Count : Count<kLeft - 1, kLeft - 1, kCounted...> {};
template <int... kCounted>
struct Count<0, kCounted...> {
  using Numbers = Indices<kCounted...>;
};
using Lanes = Count<kLanes>::Numbers;

template <int... kLane>
inline Vec lane_numbers(Indices<kLane...>) {
  return Vec{kLane...};
}

/// Whether any lane of a comparison holds. The compiler's own functions, for it does not find these
/// instructions.
inline bool any(IntVec mask) {
#if defined(__AVX512DQ__)
  return __builtin_ia32_cvtq2mask512(mask) != 0;
#elif defined(__AVX2__)
  return __builtin_ia32_movmskpd256(__builtin_bit_cast(Vec, mask)) != 0;
#elif defined(__SSE2__)
  return __builtin_ia32_movmskpd(__builtin_bit_cast(Vec, mask)) != 0;
#else
  long long some = 0;
  for (int i = 0; i < kLanes; ++i) some |= mask[i];
  return some != 0;
#endif
}

/// Lanes of `a` where `mask` is all ones, of `b` where it is zero.
inline Vec choose(IntVec mask, Vec a, Vec b) {
  return __builtin_bit_cast(Vec,
                            (__builtin_bit_cast(IntVec, a) & mask) | (__builtin_bit_cast(IntVec, b) & ~mask));
}

/// Sums of neighbours at distance kStep, those of `a` and of `b` in turn.
template <int kStep, int... kLane>
inline Vec sums_of_neighbours(Vec a, Vec b, Indices<kLane...>) {
  constexpr auto first = [](int lane) {
    const int in_pair = lane % (2 * kStep);
    return lane - in_pair + in_pair % kStep + (in_pair < kStep ? 0 : kLanes);
  };
  return __builtin_shufflevector(a, b, first(kLane)...) +
         __builtin_shufflevector(a, b, (first(kLane) + kStep)...);
}

/// Halves the number of vectors until one is left.
template <int kStep = 1>
inline void fold(Vec* v) {
  for (int i = 0; i < kLanes / (2 * kStep); ++i)
    v[i] = sums_of_neighbours<kStep>(v[2 * i], v[2 * i + 1], Lanes{});
  if constexpr (2 * kStep < kLanes) fold<2 * kStep>(v);
}

/// The sum of each of kLanes vectors, which are overwritten: lane i holds that of v[i].
inline Vec sums(Vec* v) {
  fold(v);
  return v[0];
}

inline double sum(Vec v) {
  double total = 0;
  for (int i = 0; i < kLanes; ++i) total += v[i];
  return total;
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
