#include "config/table/column_name.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <utility>
#include <vector>

namespace truepose::config {
namespace {

bool is_decimal_digit(char c) { return c >= '0' && c <= '9'; }

std::string lower(std::string_view text) {
  std::string result{text};
  std::ranges::transform(result, result.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

std::string_view trimmed_name(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

/// Without what programs put between the parts of a name.
std::string compact(std::string_view name) {
  std::string result;
  for (const char c : name)
    if (!std::string_view{" _-.:/[]()$#\"'\t"}.contains(c)) result += c;
  return result;
}

/// "q1" of "a1", "joint1"; with any number, 0 included.
std::string joint_name(std::string_view name) {
  constexpr std::array<std::string_view, 8> kBefore{"aipos",          "axisact",       "axisactmeas",
                                                    "jointpositions", "jointposition", "actualposition",
                                                    "actual",         "jointstate"};
  constexpr std::array<std::string_view, 22> kFamilies{"gelenk",
                                                       "q",
                                                       "a",
                                                       "j",
                                                       "jt",
                                                       "joint",
                                                       "jointa",
                                                       "jointangle",
                                                       "jointpos",
                                                       "axis",
                                                       "axisangle",
                                                       "achse",
                                                       "achswinkel",
                                                       "theta",
                                                       "th",
                                                       "\xCE\xB8",
                                                       "rax",
                                                       "axe",
                                                       "asse",
                                                       "eje",
                                                       "\xE8\xBD\xB4",
                                                       "\xE5\x85\xB3\xE8\x8A\x82"};
  for (const std::string_view actual : {"actual", "act", "istwert", "ist", "measured", "meas"})
    if (name.ends_with(actual)) {
      name.remove_suffix(actual.size());
      break;
    }
  const auto digits = name.find_last_not_of("0123456789") + 1;
  if (digits == name.size() || digits == 0 || name.size() - digits > 2) return {};
  const std::string_view family = name.substr(0, digits);
  std::string_view number = name.substr(digits);
  if (number.size() > 1 && number[0] == '0') number.remove_prefix(1);
  const bool is_known = std::ranges::any_of(kFamilies, [&](std::string_view each) {
    return family == each || std::ranges::any_of(kBefore, [&](std::string_view before) {
             return family.starts_with(before) && family.substr(before.size()) == each;
           });
  });
  if (!is_known) return {};
  std::string joint = "q";
  return joint += number;
}

/// "x" of "pos_x" and "x_measured"; no name says the tracker's and the robot's own position alike.
std::string coordinate_name(std::string_view name) {
  constexpr std::array<std::string_view, 22> kAround{"pos",
                                                     "position",
                                                     "tracker",
                                                     "meas",
                                                     "measured",
                                                     "coord",
                                                     "coordinate",
                                                     "coordinates",
                                                     "point",
                                                     "trackerpos",
                                                     "smr",
                                                     "reflector",
                                                     "gemessen",
                                                     "messpunkt",
                                                     "lasertracker",
                                                     "smrpos",
                                                     "trackerposition",
                                                     "lt",
                                                     "laser",
                                                     "mesure",
                                                     "mesur\xC3\xA9",
                                                     "\xE5\x9D\x90\xE6\xA0\x87"};
  for (const char axis : {'x', 'y', 'z'}) {
    if (name.size() == 1 && name[0] == axis) return {axis};
    const bool is_known = std::ranges::any_of(kAround, [&](std::string_view each) {
      return name.size() == each.size() + 1 && ((name.starts_with(each) && name.back() == axis) ||
                                                (name.front() == axis && name.substr(1) == each));
    });
    if (is_known) return {axis};
  }
  return {};
}

/// Names of an orientation that is converted, and of external axes.
std::string other_name(std::string_view name) {
  constexpr std::array<std::string_view, 6> kQuaternion{"q", "quat", "quaternion", "orientation", "rot", "o"};
  constexpr std::array<std::string_view, 4> kExternal{"e", "ext", "externalaxis", "extaxis"};
  for (const char part : {'w', 'x', 'y', 'z'}) {
    if (std::ranges::any_of(kQuaternion,
                            [&](std::string_view each) {
                              return name.starts_with(each) && name.size() == each.size() + 1 &&
                                     name.back() == part;
                            }) &&
        name != "oy")
      return std::string{"q"} + part;
  }
  for (const std::string_view angle : {"roll", "pitch", "yaw", "w", "p", "r", "rx", "ry", "rz"})
    if (name == angle) return std::string{angle};
  const auto digits = name.find_last_not_of("0123456789") + 1;
  const bool is_external =
      digits + 1 == name.size() && std::ranges::find(kExternal, name.substr(0, digits)) != kExternal.end();
  return is_external ? std::string{"e"}.append(name.substr(digits)) : std::string{};
}

std::string name_without_unit(std::string_view header) {
  const std::string name = lower(trimmed_name(header));
  if (is_own_column_name(name)) return name;
  const std::string plain = compact(name);
  for (const auto& find : {joint_name, coordinate_name, other_name})
    if (std::string found = find(plain); !found.empty()) return found;
  return {};
}

/// The name before a unit in brackets at its end, and the unit: "A1", "deg" of "A1 (deg)".
std::pair<std::string_view, std::string> unit_in_brackets(std::string_view header) {
  for (const auto& [open, close] : {std::pair{'(', ')'}, std::pair{'[', ']'}, std::pair{'<', '>'}}) {
    const auto at = header.rfind(open);
    if (!header.ends_with(close) || at == std::string_view::npos || at == 0) continue;
    return {header.substr(0, at), unit_word(header.substr(at + 1, header.size() - at - 2))};
  }
  return {header, {}};
}

/// The same of a unit as the last word: "x_mm", "A1 deg", "X/mm", "x in m".
std::pair<std::string_view, std::string> unit_at_end(std::string_view header) {
  const auto at = header.find_last_of(" _/.,-");
  if (at == std::string_view::npos || at == 0) return {header, {}};
  std::string unit = unit_word(header.substr(at + 1));
  std::string_view name = header.substr(0, at);
  if (const std::string_view in = trimmed_name(name); lower(in).ends_with(" in"))
    name = in.substr(0, in.size() - 3);
  return {name, std::move(unit)};
}

}  // namespace

std::string unit_word(std::string_view word) {
  struct Unit {
    std::string_view unit;
    std::vector<std::string_view> words;
  };
  static const std::array kUnits{
      Unit{"deg", {"deg", "degree", "degrees", "grad", "\xC2\xB0", "\xC2\xBA", "deg.", "\xE5\xBA\xA6"}},
      Unit{"rad", {"rad", "radian", "radians", "\xE5\xBC\xA7\xE5\xBA\xA6"}},
      Unit{"gon", {"gon", "grade", "grades", "gradian", "gradians"}},
      Unit{"mm",
           {"mm", "millimeter", "millimeters", "millimetre", "millimetres", "\xE6\xAF\xAB\xE7\xB1\xB3"}},
      Unit{"cm", {"cm", "centimeter", "centimeters", "centimetre", "centimetres"}},
      Unit{"m", {"m", "meter", "meters", "metre", "metres", "\xE7\xB1\xB3"}},
      Unit{"um",
           {"um", "\xC2\xB5m", "\xCE\xBCm", "micron", "microns", "micrometer", "micrometers", "micrometre"}},
      Unit{"inch", {"in", "inch", "inches", "zoll", "\""}},
      Unit{"mrad", {"mrad"}},
      Unit{"arcmin", {"arcmin"}},
      Unit{"arcsec", {"arcsec"}},
      Unit{"dm", {"dm"}},
      Unit{"feet", {"ft", "foot", "feet"}}};
  std::string plain = lower(trimmed_name(word));
  if (plain.size() > 2 && std::string_view{"[("}.contains(plain.front()))
    plain = plain.substr(1, plain.size() - 2);
  for (const auto& [unit, words] : kUnits)
    if (std::ranges::find(words, plain) != words.end()) return std::string{unit};
  return {};
}

ColumnName column_name(std::string_view header) {
  const std::string_view whole = trimmed_name(header);
  if (std::string name = name_without_unit(whole); !name.empty()) return {std::move(name), {}};
  std::string said;
  for (const auto& [name, unit] : {unit_in_brackets(whole), unit_at_end(whole)}) {
    if (unit.empty()) continue;
    if (std::string found = name_without_unit(name); !found.empty()) return {std::move(found), unit};
    said = unit;
  }
  return {{}, said};
}

bool holds_words(std::string_view name) {
  constexpr std::array<std::string_view, 7> kWords{"smr",   "set",       "time",   "point",
                                                   "cycle", "direction", "program"};
  return std::ranges::find(kWords, name) != kWords.end();
}

bool is_key_name(std::string_view header) {
  constexpr std::array<std::string_view, 26> kKeys{
      "point",   "pointname",  "name",      "punkt",  "punktname",  "target",  "targetname",
      "id",      "nr",         "no",        "number", "num",        "index",   "pose",
      "posenr",  "poseid",     "row",       "label",  "objectname", "feature", "collectiongrouppoint",
      "pointid", "posenumber", "messpunkt", "time",   "timestamp"};
  return std::ranges::find(kKeys, compact(lower(trimmed_name(header)))) != kKeys.end();
}

bool names_a_sum(std::string_view field) {
  constexpr std::array<std::string_view, 17> kSums{
      "sum",     "total",  "mean",       "average", "avg",
      "min",     "max",    "std",        "stdev",   "range",
      "summe",   "mittel", "mittelwert", "median",  "standardabweichung",
      "moyenne", "somme"};
  return std::ranges::find(kSums, lower(trimmed_name(field))) != kSums.end();
}

bool names_validity(std::string_view header) {
  constexpr std::array<std::string_view, 6> kNames{"valid",  "is_valid", "isvalid",
                                                   "gültig", "gueltig",  "valide"};
  return std::ranges::find(kNames, lower(trimmed_name(header))) != kNames.end();
}

bool says_invalid(std::string_view field) {
  constexpr std::array<std::string_view, 11> kWords{
      "0", "false", "no", "n", "nein", "non", "invalid", "ungültig", "ungueltig", "falsch", "faux"};
  return std::ranges::find(kWords, lower(trimmed_name(field))) != kWords.end();
}

bool may_be_joint(std::string_view header) {
  const std::string name = lower(header);
  return std::ranges::any_of(std::array{"joint", "axis", "achs", "position"},
                             [&](const char* word) { return name.contains(word); });
}

bool may_be_coordinate(std::string_view header, char axis) {
  constexpr std::array<std::string_view, 47> kNoReading{
      "temp",      "nom",    "nominal",  "soll",   "sollwert", "cmd",        "command",  "commanded",
      "set",       "target", "ziel",     "std",    "sdev",     "stdev",      "sigma",    "dev",
      "deviation", "abw",    "error",    "err",    "delta",    "diff",       "rms",      "unc",
      "u",         "s",      "d",        "tol",    "robot",    "programmed", "residual", "tcp",
      "tool",      "flange", "force",    "torque", "moment",   "velocity",   "vel",      "acc",
      "angle",     "euler",  "rotation", "normal", "offset",   "corr",       "rkorr"};
  bool has_axis = false;
  std::string word;
  for (const char c : lower(header) + ' ') {
    if (std::isalnum(static_cast<unsigned char>(c)) || static_cast<unsigned char>(c) >= 0x80) {
      word += c;
      continue;
    }
    if (std::ranges::find(kNoReading, word) != kNoReading.end()) return false;
    has_axis |= word == std::string_view{&axis, 1};
    word.clear();
  }
  return has_axis;
}

bool names_the_tracker(std::string_view header) {
  const std::string name = lower(header);
  return std::ranges::any_of(std::array{"track", "smr", "laser", "lt", "mea", "mes", "refl"},
                             [&](const char* word) { return name.contains(word); });
}

const std::vector<std::string>& own_column_names() {
  static const std::vector<std::string> names{
      "q1",    "x",         "y",    "z",           "smr",          "set",       "sigma",     "excess",
      "time",  "pose",      "dir1", "temp1",       "payload_kg",   "payload_x", "payload_y", "payload_z",
      "a",     "b",         "c",    "sigma_abc",   "point",        "px",        "py",        "pz",
      "cycle", "direction", "cx",   "cy",          "cz",           "ca",        "cb",        "cc",
      "s",     "t",         "e1",   "residual_mm", "residual_deg", "sigma_mm"};
  return names;
}

bool is_own_column_name(std::string_view name) {
  std::string first{name};
  if (name.size() > 1 && is_decimal_digit(name.back()) && name[0] != '0') {
    const auto digits = name.find_last_not_of("0123456789") + 1;
    if (digits == 0 || name[digits] == '0') return false;
    first = std::string{name.substr(0, digits)} + "1";
  }
  return std::ranges::find(own_column_names(), first) != own_column_names().end();
}

}  // namespace truepose::config
