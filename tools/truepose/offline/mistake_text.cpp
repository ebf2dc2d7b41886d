#include "tools/truepose/offline/mistake_text.hpp"

#include <algorithm>

#include "config/robot_fix.hpp"

namespace truepose::tools {
namespace {

std::string place_of(const Mistake& mistake, const std::string& robot_file, const std::string& data_file) {
  if (mistake.file == MistakenFile::Measurements) return data_file + ": " + mistake.key;
  const std::string first_key = mistake.key.substr(0, mistake.key.find(','));
  return config::robot_place(robot_file, mistake.joint, first_key);
}

}  // namespace

std::string mistake_text(const ProbableCause& cause, const std::string& robot_file,
                         const std::string& data_file) {
  if (cause.mistakes.empty()) return data_file + ": " + in_words(cause);
  std::string places;
  for (const Mistake& mistake : cause.mistakes) places += place_of(mistake, robot_file, data_file) + ": ";
  const bool by_hand = std::ranges::any_of(cause.mistakes, &Mistake::needs_manual_fix);
  return places + in_words(cause) + (by_hand ? "" : "; `truepose robot fix` writes it corrected");
}

}  // namespace truepose::tools
