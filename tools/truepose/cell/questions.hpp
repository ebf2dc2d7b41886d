#pragma once

#include <functional>
#include <string>
#include <vector>

namespace truepose::tools {

/// What a command needs to know: by an option, else by a question.
struct Question {
  std::string* answer;                                     ///< empty: it is asked
  std::string text;                                        ///< "Address of the tracker (HOST:PORT)"
  std::function<std::string()> otherwise;                  ///< default, by the answers before
  std::function<std::string(const std::string&)> why_not;  ///< empty for an answer that may be
};

/// Asks on standard output what no option has answered, one line each; an empty line takes the default. An
/// answer that may not be is asked again. Throws CommandError (kBadInput) where an option's value may not be,
/// and where the input ends before the last answer.
void ask(const std::vector<Question>& questions);

}  // namespace truepose::tools
