#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// An arm and the points that it has to explain, as given or with mistakes fixed.
struct ModelAndPoints {
  RobotModel arm;
  std::vector<Measurement> points;
  std::vector<int> open;  ///< parameters of the links, from the first link's on, of which nothing is known
  std::vector<double> before;  ///< what each of them was before it was opened
  int from_row = 0;            ///< of the file, from which on rows were moved; 0: all or none
};

enum class MistakenFile { Robot, Measurements };

/// The description of a mistake and of its fix.
struct MistakeWords {
  std::string wrong;   ///< "joint 3 turns the other way"
  std::string remedy;  ///< "sign -1"
};

/// A mistake that robot files or measurement files may contain, and how to undo it.
struct Mistake {
  MistakenFile file = MistakenFile::Robot;
  int joint = -1;   ///< of the robot file, from 0; -1: all of them
  std::string key;  ///< of the robot file ("sign"), or columns of the measurements ("q2, q3")
  std::function<void(ModelAndPoints&)> apply_fix;
  std::function<MistakeWords(const RobotModel& given, const ModelAndPoints& fixed)> words;
  bool needs_all_rows = false;    ///< its fix changes the order of the rows, which a sample does not show
  bool needs_manual_fix = false;  ///< no file can be written that is right: the remedy says what to do
};

/// A mistake of all rows of the robot file alike.
Mistake of_robot_file(std::string key, MistakeWords words, std::function<void(RobotModel&)> apply_fix);

/// A mistake of all points alike.
Mistake of_points(std::string columns, MistakeWords words, std::function<void(Measurement&)> apply_fix);

/// Each joint turning the other way.
std::vector<Mistake> sign_mistakes(const RobotModel& robot);

/// Zeros off by a right angle or two.
std::vector<Mistake> zero_mistakes(const RobotModel& robot);

/// What a robot file may have wrong in one row: a sign, a zero by right angles, an alpha's sign, a and d
/// swapped.
std::vector<Mistake> row_mistakes(const RobotModel& robot);

/// A zero or a length that is off by any amount, which is left open.
std::vector<Mistake> open_mistakes(const RobotModel& robot);

/// A robot file by another convention: a and alpha one row too early, as in standard DH, or too late.
std::vector<Mistake> convention_mistakes();

/// Columns of the measurements swapped, and joints shown against the one before.
std::vector<Mistake> column_mistakes(const RobotModel& robot);

/// Two and more joints turning the other way (two alone beyond eight joints), the fewest first.
std::vector<Mistake> sign_set_mistakes(const RobotModel& robot);

}  // namespace truepose
