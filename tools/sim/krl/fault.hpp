#pragma once

#include <string>

namespace truepose::sim::krl {

/// A variable has no value, an interrupt is not declared. Source: KUKA's bas.src and tm_bib.src compare with
/// them.
inline constexpr int kNoValueError = 1422, kNoInterruptError = 1430;

/// What is wrong with a KRL text or with its run, and where. Thrown inside of the interpreter, since nearly
/// every step of a compiler may find one; load() and Interpreter::run() give it as a value.
struct Fault {
  std::string file;
  int line = 0;      ///< from 1; 0: of the file as a whole
  std::string what;  ///< one sentence without its full stop
  int number = 1;    ///< of $ERR: KUKA's where a program of KUKA's own asks for it, else 1

  /// "moves.src:12: the name X is not known"
  std::string text() const { return file + ":" + std::to_string(line) + ": " + what; }
};

}  // namespace truepose::sim::krl
