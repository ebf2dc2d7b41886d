#include "core/calibration/null_space.hpp"

#include <gmock/gmock.h>
#include <iostream>

#include "core/calibration/identifiability.hpp"
#include "core/calibration/measurement_model.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

NullSpace null_space_of(const CalibratedCell& cell, const MeasurementData& data) {
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, data.points, f, J);
  const ParameterLayout layout = ParameterLayout::of(cell);
  NullSpace n = null_space(J / 0.02, parameter_names(cell), conventional_preference(layout), usual_deviation(layout));
  std::cout << "rank " << n.rank << " gap " << n.gap << "\n";
  for (auto& c : n.unknown) std::cout << "  " << c.sentence << "\n";
  for (auto& c : n.weak) std::cout << "  W " << c.sentence << "\n";
  std::cout << " err " << (J * n.basis).norm() << "\n";
  return n;
}

TEST(NullSpace, Explore) {
  Random random{1};
  for (auto robot : {example::kr210(), example::kr210_on_a_rail(), example::seven_axis()}) {
    for (int r : {1, 3}) {
    auto cell = example::placed(robot, random, r);
    std::cout << robot.name << " " << r << "\n";
    null_space_of(cell, example::measured(cell, 60, 0, random));
    cell.base.rxyz_rad.setZero();
    null_space_of(cell, example::measured(cell, 60, 0, random));
    null_space_of(cell, example::measured(cell, 12, 0, random));
    }
  }
  auto cell = example::placed(example::kr210(), random, 1);
  auto data = example::measured(cell, 60, 0, random);
  const JointVector q = data.points[0].q;
  for (auto& p : data.points) { const double q1 = p.q[0]; p.q = q; p.q[0] = q1; }
  std::cout << "axis 1 only\n";
  null_space_of(cell, data);
  for (auto& p : data.points) { std::swap(p.q[0], p.q[4]);}
  std::cout << "axis 5 only\n";
  null_space_of(cell, data);
  // constant orientation
  for (auto& p : data.points) { p.q[0] = 0; p.q[1] = random.uniform(-2.4, -0.1); p.q[2] = random.uniform(-2, 2.8); p.q[3] = 0; p.q[4] = - p.q[1] - p.q[2]; p.q[5] = 0;}
  std::cout << "constant orientation\n";
  null_space_of(cell, data);
  cell.robot = example::with_paper_errors(cell.robot);
  std::cout << "fitted arm\n";
  null_space_of(cell, example::measured(cell, 60, 0, random));
}

}  // namespace
}  // namespace truepose
