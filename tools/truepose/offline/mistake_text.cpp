#include "tools/truepose/offline/mistake_text.hpp"

#include <algorithm>

#include "config/robot_fix.hpp"

namespace truepose::tools {
namespace {

/// Each place of the robot file, and the columns of the measurements together.
std::string places_of(const std::vector<Mistake>& mistakes, const std::string& robot_file,
                      const std::string& data_file) {
  std::string places, columns;
  for (const Mistake& mistake : mistakes) {
    if (mistake.file == MistakenFile::Measurements) {
      columns += (columns.empty() ? "" : ", ") + mistake.key;
      continue;
    }
    const std::string first_key = mistake.key.substr(0, mistake.key.find(','));
    const std::string place = config::robot_place(robot_file, mistake.joint, first_key) + ": ";
    if (!places.contains(place)) places += place;
  }
  return places + (columns.empty() ? "" : data_file + ": " + columns + ": ");
}

}  // namespace

std::string mistake_text(const ProbableCause& cause, const std::string& robot_file,
                         const std::string& data_file) {
  if (cause.mistakes.empty()) return data_file + ": " + in_words(cause);
  const bool by_hand = std::ranges::any_of(cause.mistakes, &Mistake::needs_manual_fix);
  return places_of(cause.mistakes, robot_file, data_file) + in_words(cause) +
         (by_hand ? "" : "; `truepose robot fix` writes it corrected");
}

}  // namespace truepose::tools
