#include "core/kernels/frames.hpp"
#include "core/kernels/table.hpp"

TRUEPOSE_KERNELS_OF(TRUEPOSE_KERNEL_ISA)

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {

void sincos_array(const double* angle, double* sine, double* cosine, int count) {
  int i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    const SinCos both = sincos(load(angle + i));
    store(sine + i, both.sine);
    store(cosine + i, both.cosine);
  }
  if (i == count) return;
  Vec last{};
  for (int k = 0; i + k < count; ++k) last[k] = angle[i + k];
  const SinCos both = sincos(last);
  for (int k = 0; i + k < count; ++k) {
    sine[i + k] = both.sine[k];
    cosine[i + k] = both.cosine[k];
  }
}

void forward(const Arm& arm, const double* q, double* pose) {
  LinkTransforms links;
  link_transforms(arm, q, links);
  Frame X = frame(links.T[0]);
  for (int i = 1; i < arm.joints; ++i) X = X * links.T[i];
  store_pose(X * arm.transform[arm.joints], pose);
}

void forward_jacobian(const Arm& arm, const double* q, double* pose, double* jacobian) {
  JacobianColumn J[kMostJoints];
  store_pose(pose_and_jacobian(arm, q, J), pose);
  for (int i = 0; i < arm.joints; ++i) {
    for (int k = 0; k < 3; ++k) {
      jacobian[6 * i + k] = J[i].moving[k];
      jacobian[6 * i + 3 + k] = J[i].turning[k];
    }
  }
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
