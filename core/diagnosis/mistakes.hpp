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

/// Each joint turning the other way.
std::vector<Mistake> sign_mistakes(const RobotModel& robot);

/// Zeros off by a right angle or two.
std::vector<Mistake> zero_mistakes(const RobotModel& robot);

/// What a robot file may have wrong in one row: a sign, a zero by right angles, an alpha's sign, a and d
/// swapped.
std::vector<Mistake> row_mistakes(const RobotModel& robot);

/// A zero or a length that is off by any amount, which is left open.
std::vector<Mistake> open_mistakes(const RobotModel& robot);

/// Angles and lengths of the robot file in other units.
std::vector<Mistake> robot_unit_mistakes();

/// What else concerns a whole file: its convention, the measurements' units, its columns, its joints' order
/// and coupling.
std::vector<Mistake> file_mistakes(const RobotModel& robot);

/// Robot file and points both in metres.
std::vector<Mistake> metres_for_mm();

/// Two and more joints turning the other way (two alone beyond eight joints), the fewest first.
std::vector<Mistake> sign_set_mistakes(const RobotModel& robot);

}  // namespace truepose
