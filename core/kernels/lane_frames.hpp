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

/// X turned about its own z axis.
inline void turn(LaneFrame& X, Vec sine, Vec cosine) {
  const Lane3 x = X.x * cosine + X.y * sine;
  X.y = X.y * cosine - X.x * sine;
  X.x = x;
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
