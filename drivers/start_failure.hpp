#pragma once

#include <string>
#include <utility>

namespace truepose::drivers {

/// Why something that listens, or a file, could not be taken at the start.
struct StartFailure {
  // Converts from the sentence: most failures are mistakes, which the operator has to fix.
  StartFailure(std::string sentence, bool passes = false) : text{std::move(sentence)}, may_pass{passes} {}

  std::string text;       ///< one sentence
  bool may_pass = false;  ///< waiting may help: an address that is not there yet, a port or disk in use
};

}  // namespace truepose::drivers
