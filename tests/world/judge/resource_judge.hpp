#pragma once

#include <cstdint>
#include <string>

#include "tests/world/cell.hpp"
#include "tests/world/soak_log.hpp"

namespace truepose::world {

/// Judges what the daemon takes of its PC: memory and descriptors do not grow while it lives, and it leaves
/// none behind.
class ResourceJudge {
 public:
  ResourceJudge(Cell& cell, SoakLog& log) : cell_{cell}, log_{log} {}

  void begun();
  /// Now and then while no campaign measures.
  void look();
  /// Nothing of the process is left.
  void ended();

  std::int64_t largest_bytes = 0, largest_left_bytes = 0;

 private:
  std::int64_t descriptors() const;
  /// @param settled  the most in the first hours; what is said already
  void judge(const std::string& what, std::int64_t now, std::int64_t& settled, std::int64_t growth);

  Cell& cell_;
  SoakLog& log_;
  drivers::TimePoint begun_{}, looked_{};
  std::int64_t settled_bytes_ = 0, settled_descriptors_ = 0;  // the most in the first hours of a life
};

}  // namespace truepose::world
