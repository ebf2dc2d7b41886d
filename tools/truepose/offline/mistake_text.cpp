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

std::string mistake_text(const Suspicion& suspicion, const std::string& robot_file,
                         const std::string& data_file) {
  if (suspicion.mistakes.empty()) return data_file + ": " + in_words(suspicion);
  std::string places;
  for (const Mistake& mistake : suspicion.mistakes) places += place_of(mistake, robot_file, data_file) + ": ";
  const bool by_hand = std::ranges::any_of(suspicion.mistakes, &Mistake::is_mended_by_hand);
  return places + in_words(suspicion) + (by_hand ? "" : "; `truepose robot fix` writes it corrected");
}

}  // namespace truepose::tools
