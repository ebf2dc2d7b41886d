#pragma once

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/krl/hindrance_kinds.hpp"
#include "proto/krl/position.hpp"

namespace truepose::krl {

/// A file of a program.
struct SourceText {
  enum class Role {
    Program,  ///< .src
    Data,     ///< .dat; what it declares GLOBAL is known to all programs
    Config,   ///< $config.dat: all that it declares is
  };
  Role role = Role::Program;
  std::string module;         ///< in capitals: a .src and the .dat of one name are one module
  std::string_view text;      ///< outlives what is read from it
  bool is_changeable = true;  ///< false: programs that are not given here may use its positions too
};

/// The texts that programs consist of.
struct ProgramText {
  std::vector<SourceText> files;
  /// All programs of a controller: a file that cannot be read, or a motion whose frames are not known, keeps
  /// no other from being read.
  bool is_archive = false;
};

/// A tool or a base, as far as the text tells.
struct FrameValue {
  enum class State {
    Known,
    Unset,      ///< never set
    NoData,     ///< TOOL_DATA[number] or BASE_DATA[number], which the texts do not give
    Computed,   ///< set by a statement that cannot be evaluated
    Moving,     ///< BASE_DATA[number], carried by an external axis
    Written,    ///< TOOL_DATA[number] or BASE_DATA[number], which the program itself writes
    Unordered,  ///< may be set by a statement that is not carried out where it stands
  };
  State state = State::Unset;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();  ///< mm; where it is known
  int number = 0;
  Spot set;  ///< the statement that set it, or wrote the element
};

/// A position that motions use.
struct Point {
  std::string_view name;  ///< as declared; empty where it is written in the motion itself
  Position position;
  bool is_changeable = true;  ///< as SourceText::is_changeable
};

/// Numbers from which a motion makes its target.
struct Offset {
  enum class Kind {
    Behind,  ///< `P:{..}`, in the frame of a point
    Before,  ///< `{..}:P`, of which the point is in the frame
    Base,    ///< relative to where the arm stands, along the base: added to X, Y, Z, A, B, C
    Tool,    ///< the same along the tool
    Axes,    ///< the same of the axes
  };
  Kind kind = Kind::Behind;
  std::optional<std::size_t> point;  ///< of Program::points: that of Behind and Before
  Spot spot;
  std::array<std::optional<Number>, 6> numbers;  ///< X, Y, Z, A, B, C or A1..A6; what is not given is 0
  std::size_t closed_at = 0;                     ///< byte offset of the closing brace
};

/// A target of the arm, in the order of the text. One without a point and an offset tells that from there on
/// the place of the arm is not known.
struct Step {
  Spot spot;
  std::optional<std::size_t> point;   ///< of Program::points
  std::optional<std::size_t> offset;  ///< of Program::offsets, in place of a point
  std::size_t tool = 0, base = 0;     ///< of Program::frames
  bool fixed_tool = false;            ///< IPO_FRAME #TCP: the arm carries the workpiece
};

/// A position, or a motion, that cannot or need not be changed.
struct LeftAlone {
  Spot spot;
  std::string name;  ///< of the variable; empty where there is none
  Hindrance why;
  bool absolute = false;  ///< the arm goes to a fixed place there, which stays uncorrected
};

/// Something that the reader of the result should know.
struct Note {
  Spot spot;
  std::string text;
};

/// A fault in one of the texts.
struct ProgramFault {
  Spot spot;
  std::string what;
};

/// The targets of a KRL program.
struct Program {
  std::vector<Point> points;
  std::vector<Offset> offsets;
  std::vector<Step> steps;
  std::vector<FrameValue> frames;
  std::vector<LeftAlone> left;
  std::vector<Note> notes;
  std::vector<ProgramFault> unread;  ///< of an archive: files of which nothing was taken
};

/// TCP (in the flange frame) and base that are in effect where a routine starts, and those of TOOL_DATA and
/// BASE_DATA that the texts do not give; mm.
struct StartFrames {
  std::optional<Eigen::Isometry3d> tool, base;
  std::map<int, Eigen::Isometry3d> tools{}, bases{};
};

/// Finds the targets of all motions with the tool and the base in effect, in the order of the texts: branches
/// and loops are read once, called programs are not followed. What a called routine of these texts, a GOTO
/// passed over, a TRIGGER or an interrupt sets is unknown until it is set again. Targets that are computed,
/// partial, relative or declared elsewhere are left alone, as are declared positions that no motion uses.
/// Errors: a text or a brace that is not closed, a component given twice, a variable declared twice, a number
/// out of range, a motion without a target.
std::expected<Program, ProgramFault> read_program(const ProgramText& text, const StartFrames& start);

}  // namespace truepose::krl
