#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/data/measurement.hpp"

/// Mistakes as people make them, written down apart from the code that finds them.
namespace truepose::example {

struct Files {
  RobotModel robot;
  MeasurementData data;
};

struct PlantedMistake {
  std::string name;   ///< begins with its kind: "sign 3"
  std::string words;  ///< that the right diagnosis says
  std::function<void(Files&)> make;
  std::string kind() const { return name.substr(0, name.find(' ')); }
};

/// Every kind of mistake once or more for an arm, with amounts from `seed`.
std::vector<PlantedMistake> mistakes_of(const RobotModel& robot, int poses, std::uint64_t seed);

}  // namespace truepose::example
