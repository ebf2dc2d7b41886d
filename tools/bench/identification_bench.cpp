#include <benchmark/benchmark.h>
#include <ceres/ceres.h>

#include <array>
#include <cmath>

#include "core/calibrate/calibrate.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/fit/least_squares_solver.hpp"
#include "core/math/angles.hpp"
#include "tools/bench/jobs.hpp"

namespace truepose::bench {
namespace {

constexpr int kBase = 6, kReflector = 3, kLink = 5, kLinks = 6;
constexpr int kFree = 27;

/// Ends a fit as soon as the points are met, so that no solver polishes longer than another.
class StopWhenDone : public ceres::IterationCallback {
 public:
  explicit StopWhenDone(std::size_t points)
      : cost_(0.5 * static_cast<double>(points) * kDone_mm * kDone_mm) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    return summary.cost <= cost_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  double cost_;
};

void solve(ceres::Problem& problem, ceres::Solver::Options options, std::size_t points) {
  StopWhenDone stop(points);
  options.callbacks.push_back(&stop);
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 0;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

/// Rz(rz) Ry(ry) Rx(rx) v.
template <typename T>
std::array<T, 3> turned(const T* rxyz, const std::array<T, 3>& v) {
  using std::cos, std::sin;
  const T cx = cos(rxyz[0]), sx = sin(rxyz[0]), cy = cos(rxyz[1]), sy = sin(rxyz[1]), cz = cos(rxyz[2]),
          sz = sin(rxyz[2]);
  const T y = cx * v[1] - sx * v[2], z1 = sx * v[1] + cx * v[2];
  const T x = cy * v[0] + sy * z1, z = cy * z1 - sy * v[0];
  return {cz * x - sz * y, sz * x + cz * y, z};
}

/// The reflector is carried from the flange to the base, link by link: a vector where a pose would be twelve
/// numbers.
struct PointError {
  const Measurement& point;
  const RobotModel& robot;

  template <typename T>
  bool operator()(const T* base, const T* reflector, const T* links, T* error) const {
    using std::cos, std::sin;
    std::array<T, 3> p{reflector[0], reflector[1], reflector[2]};
    for (int i = kLinks - 1; i >= 0; --i) {
      const T* link = links + kLink * i;
      const T theta = link[3] + robot.joints[static_cast<std::size_t>(i)].sign * point.q[i];
      const T ct = cos(theta), st = sin(theta), ca = cos(link[1]), sa = sin(link[1]), cb = cos(link[4]),
              sb = sin(link[4]);
      const T x = ct * p[0] - st * p[1] + link[0], y1 = st * p[0] + ct * p[1], z1 = p[2] + link[2];
      const T y = ca * y1 - sa * z1, z = sa * y1 + ca * z1;
      p = {cb * x + sb * z, y, cb * z - sb * x};
    }
    const std::array<T, 3> at = turned(base + 3, p);
    for (int k = 0; k < 3; ++k) error[k] = base[k] + at[static_cast<std::size_t>(k)] - point.p_WS_mm[k];
    return true;
  }
};

/// The same with the derivatives of the method's geometry: an axis, or an axis crossed with the lever arm.
class PointErrorWithDerivatives : public ceres::SizedCostFunction<3, kFree> {
 public:
  /// @param nominal  values of all parameters, for those that are held
  PointErrorWithDerivatives(const Measurement& point, const Identification& job,
                            const Eigen::VectorXd& nominal)
      : point_(point), job_(job), nominal_(nominal) {}

  bool Evaluate(const double* const* parameters, double* error, double** jacobians) const override {
    Eigen::Vector<double, kBase + kReflector + kLink* kLinks> all = nominal_;
    for (std::size_t k = 0; k < kFree; ++k) all[job_.free[k]] = parameters[0][k];
    const double* const links = all.data() + kBase + kReflector;
    const Eigen::Vector3d rxyz(all[3], all[4], all[5]), p_FS(all[6], all[7], all[8]);

    std::array<Eigen::Vector3d, kLinks> x_axis, y_axis, z_axis, before, after;
    Eigen::Matrix3d R = rotation_zyx(rxyz.z(), rxyz.y(), rxyz.x());
    const Eigen::Vector3d base(all[0], all[1], all[2]);
    Eigen::Vector3d p = base;
    for (std::size_t i = 0; i < kLinks; ++i) {
      const double* const link = links + kLink * i;
      const double theta = link[3] + job_.start.robot.joints[i].sign * point_.q[static_cast<Eigen::Index>(i)];
      const double ct = std::cos(theta), st = std::sin(theta), ca = std::cos(link[1]), sa = std::sin(link[1]),
                   cb = std::cos(link[4]), sb = std::sin(link[4]);
      before[i] = p;
      y_axis[i] = R.col(1);
      x_axis[i] = R.col(0) * cb - R.col(2) * sb;
      const Eigen::Vector3d z_turned = R.col(0) * sb + R.col(2) * cb;
      const Eigen::Vector3d y = R.col(1) * ca + z_turned * sa;
      z_axis[i] = z_turned * ca - R.col(1) * sa;
      R.col(0) = x_axis[i] * ct + y * st;
      R.col(1) = y * ct - x_axis[i] * st;
      R.col(2) = z_axis[i];
      p += x_axis[i] * link[0] + z_axis[i] * link[2];
      after[i] = p;
    }
    const Eigen::Vector3d P = p + R * p_FS;
    Eigen::Map<Eigen::Vector3d> f(error);
    f = P - point_.p_WS_mm;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;

    Eigen::Map<Eigen::Matrix<double, 3, kFree, Eigen::RowMajor>> J(jacobians[0]);
    J.leftCols<3>().setIdentity();
    const Eigen::Matrix3d rates = angle_rates_zyx(rxyz);
    for (int k = 0; k < 3; ++k) J.col(3 + k) = rates.col(k).cross(P - base);
    J.middleCols<3>(6) = R;
    for (Eigen::Index c = 9; c < kFree; ++c) {
      const int of_links = job_.free[static_cast<std::size_t>(c)] - kBase - kReflector;
      const auto i = static_cast<std::size_t>(of_links / kLink);
      switch (of_links % kLink) {
        case 0:
          J.col(c) = x_axis[i];
          break;
        case 1:
          J.col(c) = x_axis[i].cross(P - before[i]);
          break;
        case 2:
          J.col(c) = z_axis[i];
          break;
        case 3:
          J.col(c) = z_axis[i].cross(P - after[i]);
          break;
        case 4:
          J.col(c) = y_axis[i].cross(P - before[i]);
          break;
      }
    }
    return true;
  }

 private:
  const Measurement& point_;
  const Identification& job_;
  const Eigen::VectorXd& nominal_;
};

CalibratedCell with_values(const CalibratedCell& start, const Eigen::VectorXd& values) {
  CalibratedCell cell = start;
  cell.base = {values.head<3>(), values.segment<3>(3)};
  cell.reflectors[0].p_FS_mm = values.segment<3>(6);
  for (int i = 0; i < kLinks; ++i) {
    Joint& joint = cell.robot.joints[static_cast<std::size_t>(i)];
    const auto link = values.segment<kLink>(kBase + kReflector + kLink * i);
    joint.a_mm = link[0];
    joint.alpha_rad = link[1];
    joint.d_mm = link[2];
    joint.theta_rad = link[3];
    joint.beta_rad = link[4];
  }
  return cell;
}

/// Ceres as its documentation leads one to use it: automatic derivatives, the base, the reflector and the
/// links as a block each, DENSE_QR, defaults; what must not move is held by a manifold.
CalibratedCell fit_ceres_auto(const Identification& job) {
  Eigen::VectorXd values = parameter_values(job.start);
  double* const base = values.data();
  double* const reflector = base + kBase;
  double* const links = reflector + kReflector;
  ceres::Problem problem;
  for (const Measurement& point : job.points) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<PointError, 3, kBase, kReflector, kLink * kLinks>(
            new PointError{point, job.start.robot}),
        nullptr, base, reflector, links);
  }
  std::vector<int> held;
  for (int k = 0; k < kLink * kLinks; ++k)
    if (!std::ranges::binary_search(job.free, kBase + kReflector + k)) held.push_back(k);
  problem.SetManifold(links, new ceres::SubsetManifold(kLink * kLinks, held));
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  solve(problem, options, job.points.size());
  return with_values(job.start, values);
}

/// Ceres at its best here: analytic derivatives to the 27 free parameters alone, DENSE_NORMAL_CHOLESKY, and a
/// trust region so wide that every step is a full one.
CalibratedCell fit_ceres_tuned(const Identification& job) {
  const Eigen::VectorXd nominal = parameter_values(job.start);
  std::array<double, kFree> free;
  for (std::size_t k = 0; k < kFree; ++k) free[k] = nominal[job.free[k]];
  ceres::Problem problem;
  for (const Measurement& point : job.points)
    problem.AddResidualBlock(new PointErrorWithDerivatives(point, job, nominal), nullptr, free.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.initial_trust_region_radius = 1e16;
  solve(problem, options, job.points.size());
  Eigen::VectorXd values = nominal;
  for (std::size_t k = 0; k < kFree; ++k) values[job.free[k]] = free[k];
  return with_values(job.start, values);
}

// ---- What is timed ----

/// Runs the fit from the same start each time, problem building included, and checks where it ended.
template <typename Fit>
void identify(benchmark::State& state, Fit fit) {
  const Identification job = identification(static_cast<int>(state.range(0)));
  CalibratedCell cell;
  for (auto _ : state) cell = fit(job);
  if (!(rms_mm(cell, job.points) < kDone_mm)) state.SkipWithError("did not reach 1e-9 mm");
}

void identify_auto(benchmark::State& state) { identify(state, fit_ceres_auto); }
void identify_tuned(benchmark::State& state) { identify(state, fit_ceres_tuned); }
void identify_truepose(benchmark::State& state) {
  identify(state, [](const Identification& job) {
    const LeastSquaresProblem problem{.points = job.points, .free = job.free, .W = {}, .prior = {}};
    return gauss_newton(job.start, problem).cell;
  });
}

/// All that `truepose calibrate` asks for by default: the check of the model, both stages, what the poses
/// leave open, the uncertainty of parameters and predictions.
void calibrate_truepose(benchmark::State& state) {
  identify(state, [](const Identification& job) {
    const MeasurementData data{.smr_names = {job.start.reflectors.front().name}, .points = job.points};
    const auto calibration = calibrate(job.start.robot, data);
    return calibration ? calibration->cell : job.start;
  });
}

void points(benchmark::internal::Benchmark* job) { job->Arg(30)->Arg(100)->Arg(300)->Arg(1000); }
BENCHMARK(identify_auto)->Name("identify/ceres_auto")->Apply(points);
BENCHMARK(identify_tuned)->Name("identify/ceres_tuned")->Apply(points);
BENCHMARK(identify_truepose)->Name("identify/truepose")->Apply(points);
BENCHMARK(calibrate_truepose)->Name("calibrate/truepose")->Apply(points);

}  // namespace
}  // namespace truepose::bench
