// KRL programs: program, data list and $config.dat, in this order, with a line "====" between them. With the
// same numbers a program stays the same byte for byte, and with other numbers it is the same program with
// those.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "proto/krl/frame_data.hpp"
#include "proto/krl/places.hpp"
#include "proto/krl/program.hpp"
#include "proto/krl/program_statement.hpp"
#include "proto/krl/rewrite.hpp"
#include "tests/fuzz/target.hpp"
#include "tests/proto/krl_text.hpp"

namespace truepose::fuzz {
namespace {

using krl::Edit;

constexpr double kShift = 0.25;    // what every number is moved by
constexpr double kGreatest = 1e6;  // beyond it a shift may be lost in rounding

std::string_view next_part(std::string_view& text) {
  constexpr std::string_view kSeparator = "====\n";
  const std::size_t end = std::min(text.find(kSeparator), text.size());
  const std::string_view part = text.substr(0, end);
  text.remove_prefix(std::min(end + kSeparator.size(), text.size()));
  return part;
}

/// Edits by file, one for every number of every point that may be changed.
template <typename NewText>
std::map<std::size_t, std::vector<Edit>> edits(const krl::Program& program, const krl::ProgramText& text,
                                               NewText new_text) {
  std::map<std::size_t, std::vector<Edit>> edits;
  std::set<std::pair<std::size_t, std::size_t>> seen;
  for (const krl::Point& point : program.points) {
    const std::size_t file = point.position.spot.file;
    expect(point.is_changeable == text.files[file].is_changeable,
           "a point may be changed where its file may");
    if (!point.is_changeable) continue;
    const std::string_view source = text.files[file].text;
    for (const krl::Number& number : point.position.values) {
      expect(number.begin < number.end && number.end <= source.size(), "a number stands in its text");
      expect(seen.insert({file, number.begin}).second, "a number belongs to one point");
      edits[file].push_back({number.begin, number.end, new_text(number, source)});
    }
  }
  return edits;
}

/// "X5" would be another name, so a blank is put there: in front of .5 or 'B01', which may touch theirs.
bool touches_its_name(const krl::Number& number, std::string_view source) {
  return number.begin > 0 && source[number.begin] != '-' && source[number.begin - 1] != ' ';
}

void expect_the_same_with_its_own_numbers(const krl::Program& program, const krl::ProgramText& text) {
  bool touches = false;
  const auto same = edits(program, text, [&](const krl::Number& number, std::string_view source) {
    expect(!krl::is_changed(number, number.value), "a number that stays is not changed");
    touches = touches || touches_its_name(number, source);
    return std::string{source.substr(number.begin, number.end - number.begin)};
  });
  for (const krl::SourceText& source : text.files)
    expect(krl::rewritten(source.text, {}) == source.text, "without corrections a program stays as it is");
  for (const auto& [file, its] : same)
    expect(touches || krl::rewritten(text.files[file].text, its) == text.files[file].text,
           "with its own numbers a program stays as it is");
}

void expect_the_new_numbers(const krl::Program& program, const krl::ProgramText& text) {
  bool sane = true;
  const auto changes = edits(program, text, [&](const krl::Number& number, std::string_view) {
    sane = sane && std::abs(number.value) < kGreatest;
    return krl::number_text(number.value + kShift);
  });
  if (!sane) return;
  std::map<std::size_t, std::string> rewritten;
  krl::ProgramText corrected = text;
  for (const auto& [file, its] : changes)
    corrected.files[file].text = rewritten[file] = krl::rewritten(text.files[file].text, its);
  const auto again = krl::read_program(corrected, {});
  expect(again.has_value(), "a corrected program is read again");
  expect(again->points.size() == program.points.size() && again->steps.size() == program.steps.size(),
         "a corrected program has the same points and steps");
  for (std::size_t k = 0; k < program.points.size(); ++k) {
    if (!program.points[k].is_changeable) continue;
    for (std::size_t i = 0; i < 6; ++i) {
      const double moved =
          again->points[k].position.values[i].value - program.points[k].position.values[i].value;
      expect(std::abs(moved - kShift) < 1e-8, "a corrected program has the new numbers");
    }
  }
}

}  // namespace

void krl(std::string_view input) {
  const std::string_view src = next_part(input), dat = next_part(input);
  const krl::ProgramText text = krl::program_text(src, dat, input);

  if (const auto statements = krl::read_statements(input))
    krl::frame_data_of(*statements);
  else
    expect(!statements.error().what.empty() && statements.error().at <= input.size(), "a fault says where");
  const auto program = krl::read_program(text, {});
  if (!program) {
    const krl::Spot spot = program.error().spot;
    const std::string_view source = text.files[spot.file].text;
    expect(!program.error().what.empty() && spot.at <= source.size(), "a fault says where");
    expect(krl::Places{source}.of(spot.at).line >= 1, "a fault stands in a line");
    return;
  }
  for (const krl::Step& step : program->steps)
    expect((!step.point || *step.point < program->points.size()) && step.tool < program->frames.size() &&
               step.base < program->frames.size(),
           "a step names what is there");
  expect_the_same_with_its_own_numbers(*program, text);
  expect_the_new_numbers(*program, text);
}

}  // namespace truepose::fuzz
