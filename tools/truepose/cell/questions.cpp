#include "tools/truepose/cell/questions.hpp"

#include <cstdio>
#include <iostream>

#include "tools/truepose/command_line.hpp"

namespace truepose::tools {
namespace {

/// @return the answer, or the default for an empty line
std::string answer_to(const Question& question, const std::string& otherwise) {
  std::printf("%s [%s]: ", question.text.c_str(), otherwise.c_str());
  std::fflush(stdout);
  std::string line;
  if (!std::getline(std::cin, line)) {
    std::printf("\n");
    throw CommandError{kBadInput, "the input ended before the question '" + question.text +
                                      "' was answered. Nothing was written. Answer it, or give its option."};
  }
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line.empty() ? otherwise : line;
}

}  // namespace

void ask(const std::vector<Question>& questions) {
  for (const Question& question : questions) {
    if (question.answer->empty()) continue;
    if (const std::string why = question.why_not(*question.answer); !why.empty())
      throw CommandError{kBadInput, question.text + ": " + why};
  }
  for (const Question& question : questions) {
    const std::string otherwise = question.otherwise();
    while (question.answer->empty()) {
      *question.answer = answer_to(question, otherwise);
      if (const std::string why = question.why_not(*question.answer); !why.empty()) {
        std::printf("%s\n", why.c_str());
        question.answer->clear();
      }
    }
  }
}

}  // namespace truepose::tools
