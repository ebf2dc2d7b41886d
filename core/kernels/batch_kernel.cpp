#include "core/kernels/lane_frames.hpp"
#include "core/kernels/table.hpp"

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {
namespace {

/// The poses of kLanes joint positions, joint i at q + i * q_stride. All sines come first: between the turns
/// they would drive the frame out of the registers.
LaneFrame poses(const Arm& arm, const double* q, long q_stride) {
  SinCos angle[kMostJoints];
  for (int i = 0; i < arm.joints; ++i)
    angle[i] = sincos(load(q + i * q_stride) * arm.turn[i] + arm.link[i].theta_rad);

  LaneFrame X = base_frame();
  for (int i = 0; i < arm.joints; ++i) {
    const Link& link = arm.link[i];
    cross_link(X, link);
    turn(X.x, X.y, angle[i].sine, angle[i].cosine);
    X.p = X.p + X.z * (load(q + i * q_stride) * arm.slide[i] + link.d_mm);
  }
  return flange_frame(X, arm);
}

void store_poses(const LaneFrame& X, double* pose, long stride) {
  const Lane3* columns[4] = {&X.x, &X.y, &X.z, &X.p};
  for (const Lane3* column : columns) {
    store(pose, column->x);
    store(pose + stride, column->y);
    store(pose + 2 * stride, column->z);
    pose += 3 * stride;
  }
}

}  // namespace

void forward_batch(const Arm& arm, const double* q, long q_stride, double* pose, long pose_stride,
                   int count) {
  int k = 0;
  for (; k + kLanes <= count; k += kLanes) store_poses(poses(arm, q + k, q_stride), pose + k, pose_stride);
  if (k == count) return;
  // The last few in a copy that fills the lanes.
  double q_last[kMostJoints * kLanes] = {}, pose_last[12 * kLanes];
  for (int i = 0; i < arm.joints; ++i)
    for (int lane = 0; k + lane < count; ++lane) q_last[i * kLanes + lane] = q[i * q_stride + k + lane];
  store_poses(poses(arm, q_last, kLanes), pose_last, kLanes);
  for (int j = 0; j < 12; ++j)
    for (int lane = 0; k + lane < count; ++lane)
      pose[j * pose_stride + k + lane] = pose_last[j * kLanes + lane];
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
