#include "tests/core/example_arms.hpp"

#include <array>
#include <numbers>

#include "core/math/angles.hpp"

namespace truepose::example {
namespace {

constexpr double kRight = std::numbers::pi / 2;

Joint revolute(double a_mm, double alpha_rad, double d_mm, double theta_rad, double sign, double min_deg,
               double max_deg) {
  return {.a_mm = a_mm,
          .alpha_rad = alpha_rad,
          .d_mm = d_mm,
          .theta_rad = theta_rad,
          .sign = sign,
          .min = min_deg * kRadPerDeg,
          .max = max_deg * kRadPerDeg,
          .speed = 2};
}

Eigen::Vector3d random_vector(Random& random, double sigma) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

}  // namespace

RobotModel kr210() {
  return {.name = "KR 210 R2700-2",
          .joints = {revolute(0, 0, 645, 0, -1, -185, 185), revolute(330, -kRight, 0, 0, 1, -140, -5),
                     revolute(1150, 0, 0, -kRight, 1, -120, 168),
                     revolute(115, -kRight, 1220, 0, -1, -350, 350), revolute(0, kRight, 0, 0, 1, -125, 125),
                     revolute(0, -kRight, 215, 2 * kRight, -1, -350, 350)}};
}

RobotModel kr210_on_a_rail() {
  RobotModel robot = kr210();
  robot.name = "KR 210 on a rail";
  robot.joints[0].alpha_rad = kRight;
  robot.joints.insert(robot.joints.begin(), {.type = JointType::Prismatic,
                                             .alpha_rad = -kRight,
                                             .d_mm = 0,
                                             .min = -2000,
                                             .max = 2000,
                                             .speed = 1000});
  return robot;
}

RobotModel lr_mate() {
  return {.name = "LR Mate 200iD",
          .joints = {revolute(0, 0, 330, 0, 1, -170, 170), revolute(50, -kRight, 0, -kRight, 1, -100, 145),
                     revolute(330, 0, 0, 0, -1, -70, 205), revolute(35, -kRight, 335, 0, -1, -190, 190),
                     revolute(0, kRight, 0, 0, -1, -125, 125),
                     revolute(0, -kRight, 80, 2 * kRight, -1, -360, 360)},
          .coupling = {{.joint = 2, .to = 1, .factor = 1}}};
}

RobotModel seven_axis() {
  RobotModel robot{.name = "seven axes"};
  constexpr std::array kAlpha{0., -kRight, kRight, kRight, -kRight, -kRight, kRight};
  constexpr std::array kD{340., 0., 400., 0., 400., 0., 126.};
  constexpr std::array kLimit{170., 120., 170., 120., 170., 120., 175.};
  for (std::size_t i = 0; i < kD.size(); ++i) {
    robot.joints.push_back(revolute(0, kAlpha[i], kD[i], 0, 1, -kLimit[i], kLimit[i]));
  }
  return robot;
}

RobotModel ur10() {
  return {.name = "UR10e",
          .joints = {revolute(0, 0, 180.7, 0, 1, -180, 180), revolute(0, kRight, 0, 0, 1, -180, 180),
                     revolute(-612.7, 0, 0, 0, 1, -180, 180), revolute(-571.55, 0, 174.15, 0, 1, -180, 180),
                     revolute(0, kRight, 119.85, 0, 1, -180, 180),
                     revolute(0, -kRight, 116.55, 0, 1, -180, 180)}};
}

RobotModel scara() {
  RobotModel robot{.name = "SCARA",
                   .joints = {revolute(0, 0, 400, 0, 1, -130, 130), revolute(400, 0, 0, 0, 1, -145, 145),
                              revolute(0, 0, 0, 0, 1, -360, 360)}};
  robot.joints.insert(robot.joints.begin() + 2, {.type = JointType::Prismatic,
                                                 .a_mm = 350,
                                                 .alpha_rad = 2 * kRight,
                                                 .min = 0,
                                                 .max = 320,
                                                 .speed = 1000});
  return robot;
}

RobotModel with_paper_errors(RobotModel kr210, double times) {
  constexpr double kErrors[6][4] = {{0.45, 0.003, 0.72, 0.0015}, {0.63, 0.002, 0.43, 0.0032},
                                    {0.55, 0.003, 0.21, 0.0026}, {0.32, 0.006, 0.32, 0.0018},
                                    {0.72, 0.004, 0.51, 0.0012}, {0.23, 0.005, 0.62, 0.0022}};
  for (std::size_t i = 0; i < 6; ++i) {
    kr210.joints[i].a_mm += times * kErrors[i][0];
    kr210.joints[i].alpha_rad += times * kErrors[i][1];
    kr210.joints[i].d_mm += times * kErrors[i][2];
    kr210.joints[i].theta_rad += times * kErrors[i][3];
  }
  kr210.joints[2].beta_rad += times * 0.001;
  return kr210;
}

RobotModel deviating(RobotModel robot, Random& random, double sigma_mm, double sigma_rad) {
  for (Joint& joint : robot.joints) {
    for (double* length : {&joint.a_mm, &joint.d_mm}) *length += sigma_mm * random.normal();
    for (double* angle : {&joint.alpha_rad, &joint.theta_rad, &joint.beta_rad})
      *angle += sigma_rad * random.normal();
  }
  return robot;
}

RobotModel oblique_arm_on_a_rail() {
  RobotModel robot;
  robot.joints = {{.type = JointType::Prismatic,
                   .a_mm = 30,
                   .alpha_rad = 0.4,
                   .d_mm = 100,
                   .theta_rad = 0.2,
                   .beta_rad = 0.1,
                   .sign = -1,
                   .min = -500,
                   .max = 500}};
  for (int i = 0; i < 6; ++i) {
    robot.joints.push_back({.a_mm = 100. + 20 * i,
                            .alpha_rad = 0.9 - 0.5 * i,
                            .d_mm = 150. - 30 * i,
                            .theta_rad = 0.3 * i,
                            .beta_rad = 0.02 * i,
                            .sign = i % 2 ? 1. : -1.,
                            .min = -2,
                            .max = 2});
  }
  robot.X_flange = pose_from_kuka({10, -20, 30}, {15, 25, -35});
  return robot;
}

JointVector random_joints(const RobotModel& robot, Random& random) {
  JointVector q(robot.joint_count());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    q[i] = random.uniform(joint.min, joint.max);
  }
  return q;
}

CalibratedCell placed(const RobotModel& robot, Random& random, int reflectors) {
  CalibratedCell cell{robot, {random_vector(random, 3000), random_vector(random, 1)}, {}};
  for (int k = 1; k <= reflectors; ++k) {
    // On a tool, away from the last axis.
    const double angle = random.uniform(0, 2 * std::numbers::pi), radius_mm = random.uniform(60, 200);
    cell.reflectors.push_back(
        {std::to_string(k),
         {radius_mm * std::cos(angle), radius_mm * std::sin(angle), random.uniform(50, 200)}});
  }
  return cell;
}

MeasurementData measured(const CalibratedCell& truth, std::span<const JointVector> poses, double sigma_mm,
                         Random& random) {
  MeasurementData data;
  for (const Reflector& reflector : truth.reflectors) data.smr_names.push_back(reflector.name);
  for (const JointVector& q : poses) {
    for (int smr = 0; smr < static_cast<int>(truth.reflectors.size()); ++smr) {
      data.points.push_back({.q = q,
                             .p_WS_mm = truth.predict(q, smr) + random_vector(random, sigma_mm),
                             .smr = smr,
                             .row = static_cast<int>(data.points.size()) + 1});
    }
  }
  return data;
}

MeasurementData measured(const CalibratedCell& truth, int poses, double sigma_mm, Random& random) {
  MeasurementData data;
  for (int k = 0; k < poses; ++k) {
    const JointVector q = random_joints(truth.robot, random);
    for (Measurement& point : measured(truth, {&q, 1}, sigma_mm, random).points) {
      point.row = static_cast<int>(data.points.size()) + 1;
      data.points.push_back(point);
    }
  }
  for (const Reflector& reflector : truth.reflectors) data.smr_names.push_back(reflector.name);
  return data;
}

}  // namespace truepose::example
