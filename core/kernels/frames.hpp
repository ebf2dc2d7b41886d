#pragma once

#include "core/kernels/kernels.hpp"
#include "core/kernels/sincos.hpp"

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {

/// A frame of one pose: the columns of its homogeneous matrix.
struct Frame {
  Vec4 x, y, z, p;
};

/// X times the transform T, column by column.
inline Frame operator*(const Frame& X, const double* T) {
  return {X.x * T[0] + X.y * T[1] + X.z * T[2], X.x * T[4] + X.y * T[5] + X.z * T[6],
          X.x * T[8] + X.y * T[9] + X.z * T[10], X.x * T[12] + X.y * T[13] + (X.z * T[14] + X.p)};
}

/// The transforms L_i Z_i of one pose, made before they are chained, so that the chain waits for nothing
/// else.
struct alignas(64) LinkTransforms {
  double T[kMostJoints][16];
};

/// @param q  room for a multiple of kMostLanes numbers; those beyond the arm's joints are not regarded
inline void link_transforms(const Arm& arm, const double* q, LinkTransforms& links) {
  alignas(64) double sine[kMostJoints], cosine[kMostJoints];
  for (int i = 0; i < arm.joints; i += kLanes) {
    const IntVec inside = lane_numbers(Lanes{}) < static_cast<double>(arm.joints - i);
    const SinCos turn = sincos(choose(inside, load(q + i), Vec{}) * load(arm.turn + i));
    store(sine + i, turn.sine);
    store(cosine + i, turn.cosine);
  }
  for (int i = 0; i < arm.joints; ++i) {
    const double* L = arm.transform[i];
    const Vec4 x = load4(L), y = load4(L + 4), z = load4(L + 8);
    store4(links.T[i], x * cosine[i] + y * sine[i]);
    store4(links.T[i] + 4, y * cosine[i] - x * sine[i]);
    store4(links.T[i] + 8, z);
    store4(links.T[i] + 12, load4(L + 12) + z * (arm.slide[i] * q[i]));
  }
}

inline Frame frame(const double* T) { return {load4(T), load4(T + 4), load4(T + 8), load4(T + 12)}; }

inline void store_pose(const Frame& X, double* pose) {
  store4(pose, X.x);
  store4(pose + 4, X.y);
  store4(pose + 8, X.z);
  store4(pose + 12, X.p);
}

inline Vec4 cross(Vec4 a, Vec4 b) {
  const Vec4 turned =
      a * __builtin_shufflevector(b, b, 1, 2, 0, 3) - __builtin_shufflevector(a, a, 1, 2, 0, 3) * b;
  return __builtin_shufflevector(turned, turned, 1, 2, 0, 3);
}

/// What one unit of a joint does to the flange: the velocity of its origin and the angular velocity.
struct JacobianColumn {
  Vec4 moving, turning;
};

/// Pose of the flange and its geometric Jacobian.
inline Frame pose_and_jacobian(const Arm& arm, const double* q, JacobianColumn* J) {
  LinkTransforms links;
  link_transforms(arm, q, links);
  Vec4 axis[kMostJoints], origin[kMostJoints];
  Frame X = frame(links.T[0]);
  for (int i = 0;; ++i) {
    axis[i] = X.z;
    origin[i] = X.p;
    if (i + 1 == arm.joints) break;
    X = X * links.T[i + 1];
  }
  X = X * arm.transform[arm.joints];
  for (int i = 0; i < arm.joints; ++i) {
    J[i].turning = axis[i] * arm.turn[i];
    J[i].moving = cross(J[i].turning, X.p - origin[i]) + axis[i] * arm.slide[i];
  }
  return X;
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
