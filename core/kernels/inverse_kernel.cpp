#include "core/kernels/frames.hpp"
#include "core/kernels/table.hpp"

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {
namespace {

/// Six equations in room for eight: three of position, three of orientation.
struct alignas(64) Column6 {
  double row[8];

  Column6() = default;
  Column6(Vec4 position, Vec4 orientation) {
    store4(row, __builtin_shufflevector(position, orientation, 0, 1, 2, 4));
    store4(row + 4, __builtin_shufflevector(orientation, Vec4{}, 1, 2, 4, 4));
  }
  /// Adds `factor` times another.
  void add(double factor, const Column6& other) {
    store4(row, load4(row) + factor * load4(other.row));
    store4(row + 4, load4(row + 4) + factor * load4(other.row + 4));
  }
  double dot(const Column6& other) const {
    const Vec4 products = load4(row) * load4(other.row) + load4(row + 4) * load4(other.row + 4);
    return (products[0] + products[1]) + (products[2] + products[3]);
  }
};

/// Solves sum_c x_c A_c = rhs by elimination with column pivots; the columns are overwritten.
/// @return false where the matrix is singular to working precision
bool solve6(Column6* A, Column6 rhs, double* x) {
  constexpr double kSingular = 1e-13;
  int order[6] = {0, 1, 2, 3, 4, 5};
  double multiplier[6][6], part[6];
  double largest = 0;
  for (int k = 0; k < 6; ++k) {
    int at = k;
    double size = __builtin_fabs(A[order[k]].row[k]);
    for (int c = k + 1; c < 6; ++c) {
      const double other = __builtin_fabs(A[order[c]].row[k]);
      at = other > size ? c : at;
      size = other > size ? other : size;
    }
    largest = size > largest ? size : largest;
    if (!(size > kSingular * largest)) return false;
    const int pivot = order[at];
    order[at] = order[k];
    order[k] = pivot;

    const double inverse = 1 / A[pivot].row[k];
    for (int c = k + 1; c < 6; ++c) {
      Column6& column = A[order[c]];
      multiplier[k][order[c]] = column.row[k] * inverse;
      column.add(-multiplier[k][order[c]], A[pivot]);
    }
    part[k] = rhs.row[k] * inverse;
    rhs.add(-part[k], A[pivot]);
  }
  for (int k = 5; k >= 0; --k) {
    double value = part[k];
    for (int c = k + 1; c < 6; ++c) value -= multiplier[k][order[c]] * x[order[c]];
    x[order[k]] = value;
  }
  return true;
}

/// Rotation vector of E for any angle, by the quaternion.
[[gnu::noinline, gnu::cold]] Vec4 large_rotation_vector(const double (&E)[3][3]) {
  Vec4 v{E[2][1] - E[1][2], E[0][2] - E[2][0], E[1][0] - E[0][1], 0};
  const double trace = E[0][0] + E[1][1] + E[2][2];
  double w = 1 + trace;
  if (trace <= 0) {
    int i = E[1][1] > E[0][0] ? 1 : 0;
    i = E[2][2] > E[i][i] ? 2 : i;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    w = v[i];
    v[i] = 1 + E[i][i] - E[j][j] - E[k][k];
    v[j] = E[i][j] + E[j][i];
    v[k] = E[i][k] + E[k][i];
  }
  const double norm = __builtin_sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return v * (2 * __builtin_atan2(w < 0 ? -norm : norm, __builtin_fabs(w)) / norm);
}

/// Rotation vector (rad, base frame) of the turn that takes `from` to `to`. With t the vector of length
/// tan(angle / 2) along the axis it is 2 atan|t| / |t| t, a short series where the angle is small.
Vec4 rotation_vector(const Frame& from, const Frame& to) {
  const Vec4 twice_sine = cross(from.x, to.x) + cross(from.y, to.y) + cross(from.z, to.z);
  const Vec4 products = from.x * to.x + from.y * to.y + from.z * to.z;
  const double trace = products[0] + products[1] + products[2];
  const Vec4 t = twice_sine / (1 + trace);
  const double u = t[0] * t[0] + t[1] * t[1] + t[2] * t[2];
  if (trace > 0 && u < 0.01) [[likely]] {
    const double low = 1 + u * (-1. / 3 + u * (1. / 5 - u / 7));
    const double high = 1. / 9 + u * (-1. / 11 + u * (1. / 13 - u / 15));
    return t * (2 * (low + (u * u) * (u * u) * high));
  }
  double E[3][3];
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) E[a][b] = to.x[a] * from.x[b] + to.y[a] * from.y[b] + to.z[a] * from.z[b];
  return large_rotation_vector(E);
}

struct PoseError {
  Vec4 position, orientation;  ///< mm, rad, base frame
  double squared_mm, squared_rad;

  double cost(double length_mm) const { return squared_mm + length_mm * length_mm * squared_rad; }
};

PoseError pose_error(const Frame& actual, const Frame& target) {
  const Vec4 p = target.p - actual.p, r = rotation_vector(actual, target);
  const Vec4 p2 = p * p, r2 = r * r;
  return {p, r, p2[0] + p2[1] + p2[2], r2[0] + r2[1] + r2[2]};
}

/// The step of the joints that takes the error away to first order, damped by `damping` relative to the mean
/// eigenvalue of J J'; the smallest one where the arm has more than six joints. A revolute joint's radian
/// counts as length_mm of a prismatic one.
/// @return false where an undamped step of six joints does not exist
bool step(const Arm& arm, const JacobianColumn* J, const PoseError& error, double length_mm, double damping,
          double* dq) {
  const Column6 rhs(error.position, error.orientation * length_mm);
  Column6 columns[kMostJoints];
  double unit[kMostJoints];
  for (int i = 0; i < arm.joints; ++i) {
    unit[i] = arm.turn[i] != 0 ? 1.0 : length_mm;
    columns[i] = Column6(J[i].moving * unit[i], J[i].turning * (length_mm * unit[i]));
  }
  if (arm.joints == 6 && damping == 0) {
    if (!solve6(columns, rhs, dq)) return false;
    for (int i = 0; i < 6; ++i) dq[i] *= unit[i];
    return true;
  }

  Column6 normal[6];
  double trace = 0;
  for (int r = 0; r < 6; ++r) {
    normal[r] = Column6(Vec4{}, Vec4{});
    for (int i = 0; i < arm.joints; ++i) normal[r].add(columns[i].row[r], columns[i]);
    trace += normal[r].row[r];
  }
  // The floor keeps an exact singularity finite and is below rounding elsewhere.
  for (int r = 0; r < 6; ++r) normal[r].row[r] += trace / 6 * (damping > 1e-15 ? damping : 1e-15);
  Column6 along;
  if (!solve6(normal, rhs, along.row)) return false;
  for (int k = 6; k < 8; ++k) along.row[k] = 0;
  for (int i = 0; i < arm.joints; ++i) dq[i] = unit[i] * columns[i].dot(along);
  return true;
}

/// How a step is taken.
enum class Pace {
  Descend,  ///< only where it brings the pose nearer, else again with more damping
  Leap,     ///< always: it wanders, but no hollow holds it
};

/// Newton from the seed in q.
InverseOutcome newton(const Arm& arm, const Frame& goal, const InverseSettings& settings, Pace pace,
                      double* q) {
  constexpr double kFirstDamping = 1e-6, kLastDamping = 1e-9;
  alignas(64) double q_next[kMostJoints] = {};
  double dq[kMostJoints];
  JacobianColumn columns[2][kMostJoints];
  JacobianColumn *J = columns[0], *J_next = columns[1];

  PoseError error = pose_error(pose_and_jacobian(arm, q, J), goal);
  double cost = error.cost(settings.length_mm);
  double damping = 0;
  for (int iterations = 0;; ++iterations) {
    const double mm = __builtin_sqrt(error.squared_mm), rad = __builtin_sqrt(error.squared_rad);
    if (!__builtin_isfinite(cost)) return {InverseStatus::NotFinite, iterations, mm, rad};
    if (mm <= settings.position_tolerance_mm && rad <= settings.rotation_tolerance_rad)
      return {InverseStatus::Converged, iterations, mm, rad};
    if (iterations == settings.max_iterations) return {InverseStatus::DidNotConverge, iterations, mm, rad};

    bool better = step(arm, J, error, settings.length_mm, damping, dq);
    if (better) {
      for (int i = 0; i < arm.joints; ++i) q_next[i] = q[i] + dq[i];
      const PoseError next = pose_error(pose_and_jacobian(arm, q_next, J_next), goal);
      const double next_cost = next.cost(settings.length_mm);
      if (!__builtin_isfinite(next_cost)) return {InverseStatus::NotFinite, iterations, mm, rad};
      better = pace == Pace::Leap || next_cost < cost ||
               next_cost <= settings.position_tolerance_mm * settings.position_tolerance_mm;
      if (better) {
        for (int i = 0; i < arm.joints; ++i) q[i] = q_next[i];
        JacobianColumn* const last = J;
        J = J_next;
        J_next = last;
        error = next;
        cost = next_cost;
      }
    }
    if (better) {
      damping = damping < kLastDamping ? 0 : damping / 10;
    } else {
      damping = damping * 10 < kFirstDamping ? kFirstDamping : damping * 10;
    }
  }
}

}  // namespace

InverseOutcome inverse(const Arm& arm, const double* target, const InverseSettings& settings, double* q) {
  const Frame goal = frame(target);
  alignas(64) double seed[kMostJoints] = {};
  for (int i = 0; i < arm.joints; ++i) seed[i] = q[i];
  InverseOutcome outcome = newton(arm, goal, settings, Pace::Descend, q);
  // The first leaps start from the seed, later ones near it, because leaps may go in a circle.
  for (int attempt = 0; attempt < settings.leaps && outcome.status == InverseStatus::DidNotConverge;
       ++attempt) {
    for (int i = 0; i < arm.joints; ++i) {
      const double aside = 0.02 * ((i + attempt) % 3 - 1) * attempt;
      q[i] = seed[i] + aside * (arm.turn[i] != 0 ? 1.0 : settings.length_mm);
    }
    outcome = newton(arm, goal, settings, Pace::Leap, q);
  }
  return outcome;
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
