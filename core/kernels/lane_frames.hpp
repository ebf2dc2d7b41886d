#pragma once

#include "core/kernels/kernels.hpp"
#include "core/kernels/sincos.hpp"

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {

/// A vector of three coordinates in each lane.
struct Lane3 {
  Vec x, y, z;
};
inline Lane3 operator+(const Lane3& a, const Lane3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Lane3 operator-(const Lane3& a, const Lane3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Lane3 operator*(const Lane3& a, Vec s) { return {a.x * s, a.y * s, a.z * s}; }
inline Lane3 operator*(const Lane3& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
inline Lane3 cross(const Lane3& a, const Lane3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec dot(const Lane3& a, const Lane3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Lane3 all3(const double* v) { return {all(v[0]), all(v[1]), all(v[2])}; }

/// A frame of another pose in each lane.
struct LaneFrame {
  Lane3 x, y, z, p;
};

inline LaneFrame all_lanes(const double* T) { return {all3(T), all3(T + 4), all3(T + 8), all3(T + 12)}; }

/// The direction v of frame X.
inline Lane3 along(const LaneFrame& X, const double* v) { return X.x * v[0] + X.y * v[1] + X.z * v[2]; }

inline LaneFrame operator*(const LaneFrame& X, const double* T) {
  return {along(X, T), along(X, T + 4), along(X, T + 8), along(X, T + 12) + X.p};
}

/// Turns the axes u and v in their plane, u towards v.
template <typename Number>
inline void turn(Lane3& u, Lane3& v, Number sine, Number cosine) {
  const Lane3 before = u;
  u = u * cosine + v * sine;
  v = v * cosine - before * sine;
}

/// The common normal of the link after X: its x axis once turned by beta.
inline Lane3 common_normal(const LaneFrame& X, const Link& link) {
  return X.x * link.cos_beta - X.z * link.sin_beta;
}

/// Carries X to where the link's joint turns.
inline void cross_link(LaneFrame& X, const Link& link) {
  if (link.sin_beta != 0) turn(X.z, X.x, link.sin_beta, link.cos_beta);
  turn(X.y, X.z, link.sin_alpha, link.cos_alpha);
  X.p = X.p + X.x * link.a_mm;
}

inline LaneFrame base_frame() {
  constexpr double kIdentity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  return all_lanes(kIdentity);
}

inline LaneFrame flange_frame(const LaneFrame& X, const Arm& arm) {
  return arm.bare ? X : X * arm.transform[arm.joints];
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
