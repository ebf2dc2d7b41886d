#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/math/random.hpp"

/// Arms of several kinds, as they might really be, and what a tracker would read of them.
namespace truepose::example {

inline constexpr double kSigma_mm = 0.02;  ///< of a coordinate that a tracker reads

RobotModel kr210();            ///< KR 210 R2700-2
RobotModel kr210_on_a_rail();  ///< joint 1 moves the arm sideways by up to 4 m
RobotModel seven_axis();       ///< an arm with an elbow, reach 0.8 m
RobotModel ur10();             ///< an arm with three parallel axes, reach 1.3 m
RobotModel scara();            ///< turns, turns, lifts, turns: its flange is always upright; reach 0.75 m
RobotModel lr_mate();  ///< LR Mate 200iD: joint 3 is shown from the horizon, and so coupled to joint 2
/// A rail and six joints, with offsets, betas, both signs and a fixed flange: nothing that could cancel.
RobotModel oblique_arm_on_a_rail();
RobotModel with_paper_errors(RobotModel kr210, double times = 1);  ///< Table 2 of the method's paper

/// Every link off by normal deviates of these standard deviations.
RobotModel deviating(RobotModel robot, Random& random, double sigma_mm, double sigma_rad);

JointVector random_joints(const RobotModel& robot, Random& random);
CalibratedCell placed(const RobotModel& robot, Random& random, int reflectors = 1);

/// Readings of every reflector at some poses, or at so many random ones.
MeasurementData measured(const CalibratedCell& truth, std::span<const JointVector> poses, double sigma_mm,
                         Random& random);
MeasurementData measured(const CalibratedCell& truth, int poses, double sigma_mm, Random& random);

}  // namespace truepose::example
