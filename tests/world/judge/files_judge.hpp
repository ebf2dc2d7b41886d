#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges what is promised of the files next to a store, whatever went wrong since.
class FilesJudge {
 public:
  /// @param store  with an access list
  FilesJudge(const std::filesystem::path& store, SoakLog& log);

  /// A recording was saved: it is there until newer ones take its room.
  void saved(const std::filesystem::path& recording) { recording_ = recording; }
  /// Writes an access list, as the tool does.
  void change_access();

  void look();

 private:
  void look_at_audit();
  void look_at_access();
  void look_at_recording();

  const std::filesystem::path audit_, access_;
  std::filesystem::path recording_;
  SoakLog& log_;
  std::vector<std::string> lists_;  ///< of access: the last that was written, and those that failed since
  int users_ = 0;
};

}  // namespace truepose::world
