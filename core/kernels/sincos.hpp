#pragma once

#include "core/kernels/vector.hpp"

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {

struct SinCos {
  Vec sine, cosine;
};

/// The angles of which one is beyond the reduction's reach: the C library's answer.
[[gnu::noinline, gnu::cold]] inline void sincos_beyond(const double* angle, double* sine, double* cosine) {
  for (int i = 0; i < kLanes; ++i) {
    sine[i] = __builtin_sin(angle[i]);
    cosine[i] = __builtin_cos(angle[i]);
  }
}

/// Sine and cosine within 2 ulp for angles up to 1e5 rad. Cody and Waite's reduction by multiples of pi/2,
/// whose first two parts have 33 bits, so that their products with a multiple of up to 17 bits are exact;
/// then polynomials of least greatest relative error on [-pi/4, pi/4] (below 2^-57), found by Remez'
/// algorithm.
inline SinCos sincos(Vec angle) {
  constexpr double kReach = 1e5;
  constexpr double kRound = 0x1.8p52;  // adding it rounds to an integer, left in the lowest bits
  constexpr double kHalfPi[3] = {0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2e037073p-69};

  const IntVec near = (angle <= kReach) & (angle >= -kReach);
  if (any(~near)) [[unlikely]] {
    alignas(64) double in[kLanes], sine[kLanes], cosine[kLanes];
    store(in, angle);
    sincos_beyond(in, sine, cosine);
    return {load(sine), load(cosine)};
  }

  const Vec rounded = angle * 0x1.45f306dc9c883p-1 + kRound;
  const IntVec quadrant = __builtin_bit_cast(IntVec, rounded);
  const Vec n = rounded - kRound;

  // Remainder r + rest. The first difference is exact; what the second loses goes into the rest, and is
  // itself lost only where the result is not small any more.
  const Vec high = angle - n * kHalfPi[0];
  const Vec second = n * kHalfPi[1];
  const Vec middle = high - second;
  const Vec low = ((high - middle) - second) - n * kHalfPi[2];
  const Vec r = middle + low;
  const Vec rest = (middle - r) + low;

  const Vec z = r * r;
  const Vec z2 = z * z;
  const Vec s_low = -0x1.5555555555549p-3 + z * 0x1.111111110f87ap-7;
  const Vec s_mid = -0x1.a01a019c11990p-13 + z * 0x1.71de3577b65eep-19;
  const Vec s_high = -0x1.ae5e663a6459ep-26 + z * 0x1.5d9300f0397f2p-33;
  const Vec sine = r + (rest + r * z * (s_low + z2 * (s_mid + z2 * s_high)));

  const Vec c_low = 0x1.555555555554cp-5 + z * -0x1.6c16c16c1517ep-10;
  const Vec c_mid = 0x1.a01a019cb1bd8p-16 + z * -0x1.27e4f809f07b0p-22;
  const Vec c_high = 0x1.1ee9ebe913ef4p-29 + z * -0x1.8fae9c69b38f2p-37;
  const Vec cosine = 1.0 - (0.5 * z - (z2 * (c_low + z2 * (c_mid + z2 * c_high)) - r * rest));

  // Quadrants 1 and 3 exchange the two; 2 and 3 turn the sine's sign, 1 and 2 the cosine's.
  const IntVec odd = -(quadrant & 1);
  const IntVec sign_of_sine = (quadrant & 2) << 62;
  const IntVec sign_of_cosine = ((quadrant + 1) & 2) << 62;
  const Vec s = choose(odd, cosine, sine);
  const Vec c = choose(odd, sine, cosine);
  return {__builtin_bit_cast(Vec, __builtin_bit_cast(IntVec, s) ^ sign_of_sine),
          __builtin_bit_cast(Vec, __builtin_bit_cast(IntVec, c) ^ sign_of_cosine)};
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
