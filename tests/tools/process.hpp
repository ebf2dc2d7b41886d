#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace truepose {

/// What a program said and how it ended.
struct Finished {
  int exit_code = -1;  ///< -1 where a signal ended it
  std::string out, err;
};

/// Runs a program of ours from the build's bin folder and waits for its end.
Finished run_program(const std::string& name, const std::vector<std::string>& arguments);

}  // namespace truepose
