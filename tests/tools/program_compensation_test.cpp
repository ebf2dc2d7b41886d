// What becomes of the positions of a KRL program, judged by a controller and an arm of the tests' own.
#include "tools/truepose/krl/program_compensation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <sstream>

#include "core/arm/forward.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "core/simulate/published_arm.hpp"
#include "proto/krl/frame_data.hpp"
#include "tests/proto/krl_corpus.hpp"
#include "tests/tools/kuka_controller_oracle.hpp"

namespace truepose::tools {
namespace {

using krl::PositionForm;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const RobotModel kNominal = published_arm();
const RobotModel kReal = with_published_errors(kNominal);

/// Never damped.
const CompensationOptions kExact{.singular_below = 0, .approach = {}};

/// A program, and the same after its compensation.
struct Corrected {
  explicit Corrected(krl_corpus::Files in, const RobotModel& real = kReal,
                     const CompensationOptions& bounds = {})
      : before(std::move(in)), after(before) {
    program = krl::read_program(before.text(), {}).value();
    auto result =
        compensate_program(program, kNominal, StatusTurnInverse::of(kNominal).value(), real, bounds);
    if (!result) {
      fault = result.error().what;
      return;
    }
    done = std::move(*result);
    after.src = krl::rewritten(before.src, done.edits[0]);
    after.dat = krl::rewritten(before.dat, done.edits[1]);
    program_after = krl::read_program(after.text(), {}).value();
  }
  Corrected(std::string src, std::string dat, const RobotModel& real = kReal,
            const CompensationOptions& bounds = {})
      : Corrected(krl_corpus::Files{"p", std::move(src), std::move(dat), krl_corpus::bytes("config.dat")},
                  real, bounds) {}

  std::vector<std::string> left() const {
    std::vector<std::string> result;
    for (const krl::LeftAlone& left : done.left)
      result.push_back(left.name + (left.absolute ? "! " : " ") + left.why.message.what);
    return result;
  }

  krl_corpus::Files before, after;
  krl::Program program, program_after;
  ProgramCompensation done;
  std::string fault;
};

/// Joints to which a controller takes the arm: by S and T where the position has them, else the nearest.
JointVector controller_joints(const krl::Position& position, const Eigen::Isometry3d& X_BF,
                              const JointVector& from) {
  JointVector q(6);
  if (position.form == PositionForm::Axes) {
    for (std::size_t i = 0; i < 6; ++i)
      q[static_cast<Eigen::Index>(i)] = position.values[i].value * kRadPerDeg;
    return q;
  }
  const auto all = SphericalWristInverse::of(kNominal)->all(X_BF, from);
  double best = 1e300;
  for (std::size_t k = 0; k < static_cast<std::size_t>(all.count); ++k) {
    // Turns: every axis where T says, or the way that is shortest.
    JointVector candidate = all.q[k];
    for (Eigen::Index i = 0; i < 6; ++i) {
      constexpr double kRound = 2 * std::numbers::pi;
      if (position.turn) {
        const bool negative = (static_cast<int>(position.turn->value) >> i) & 1;
        if (negative && candidate[i] > 0) candidate[i] -= kRound;
        if (!negative && candidate[i] < 0) candidate[i] += kRound;
      } else {
        candidate[i] += kRound * std::round((from[i] - candidate[i]) / kRound);
      }
    }
    const bool fits =
        within_limits(kNominal, candidate) &&
        (!position.status || oracle::status(candidate) == (static_cast<int>(position.status->value) & 7));
    const double distance = (candidate - from).norm();
    if (!fits || distance > best) continue;
    best = distance;
    q = candidate;
  }
  EXPECT_LT(best, 1e300) << "the controller finds no joints";
  return q;
}

/// Runs both programs, each by the nominal controller, the corrected one on the real arm, and compares where
/// the TCP comes to.
/// @return number of targets compared
int expect_the_real_arm_where_the_nominal_one_was(const Corrected& corrected) {
  JointVector q_before = JointVector::Zero(6), q_after = q_before;
  int compared = 0;
  EXPECT_EQ(corrected.program.steps.size(), corrected.program_after.steps.size());
  EXPECT_EQ(corrected.program.points.size(), corrected.program_after.points.size());
  if (corrected.program.points.size() != corrected.program_after.points.size()) return 0;
  for (std::size_t i = 0; i < corrected.program.steps.size(); ++i) {
    const krl::Step& step = corrected.program.steps[i];
    if (!step.point) continue;
    const krl::Position& before = corrected.program.points[*step.point].position;
    const krl::Position& after = corrected.program_after.points[*step.point].position;
    const Eigen::Isometry3d& X_tool = corrected.program.frames[step.tool].X;
    const Eigen::Isometry3d& X_base = corrected.program.frames[step.base].X;
    const auto flange = [&](const krl::Position& position) {
      return position.form == PositionForm::Axes ? Eigen::Isometry3d::Identity()
                                                 : X_base * krl::pose_of(position) * X_tool.inverse();
    };
    q_before = controller_joints(before, flange(before), q_before);
    q_after = controller_joints(after, flange(after), q_after);
    if (before.spot.file == 2) continue;
    const Eigen::Isometry3d wanted = forward_kinematics(kNominal, q_before) * X_tool;
    const Eigen::Isometry3d found = forward_kinematics(kReal, q_after) * X_tool;
    EXPECT_LT((found.translation() - wanted.translation()).norm(), 1e-6) << "step " << i;
    EXPECT_LT(angle_between(found.linear(), wanted.linear()), 1e-9) << "step " << i;
    ++compared;
  }
  return compared;
}

TEST(ProgramCompensation, TheRealArmComesToWhereTheNominalOneWas) {
  for (const auto& [name, targets] : {std::pair{"gluing", 7}, {"handmade", 10}, {"splines", 8}}) {
    const Corrected corrected(krl_corpus::files(name));
    EXPECT_EQ(corrected.fault, "") << name;
    // SPTP_REL of axis 6 alone is right as it is: the arm is wrong by the same on both sides of it.
    const std::size_t unchanged = std::string_view(name) == "splines" ? 1 : 0;
    EXPECT_EQ(corrected.done.changes.size() + unchanged, corrected.done.points)
        << name << testing::PrintToString(corrected.left());
    EXPECT_EQ(expect_the_real_arm_where_the_nominal_one_was(corrected), targets) << name;
    for (const PointChange& change : corrected.done.changes) {
      EXPECT_GT(change.mm, 0.1) << name;
      EXPECT_LT(change.mm, 30) << name;
      EXPECT_LT(change.deg, 3) << name;
    }
  }
}

TEST(ProgramCompensation, TheNominalModelChangesNotOneByte) {
  for (const krl_corpus::Files& files : krl_corpus::all()) {
    if (files.name == "computed") continue;
    const Corrected corrected(files, kNominal);
    EXPECT_EQ(corrected.after.src, files.src);
    EXPECT_EQ(corrected.after.dat, files.dat);
    EXPECT_THAT(corrected.done.changes, IsEmpty());
    EXPECT_GT(corrected.done.points, 0U);
  }
}

TEST(ProgramCompensation, SaysWhatIsLeftAloneAndWhy) {
  const Corrected corrected(krl_corpus::files("computed"));
  EXPECT_THAT(
      corrected.left(),
      testing::UnorderedElementsAre(
          "XHOME is a home position of the cell", "XP2! is changed by the program",
          "! component X is missing: it keeps what the arm has then",
          "GRID[I]! is an element of an array or structure", "LOCAL_P! is computed by the program",
          "XP3! is handed to OFFSET_BY, which may change it", "XELSEWHERE! is declared in none of the files",
          " LIN_REL is relative to where the arm stands", "$AXIS_ACT is a variable of the controller",
          "XP5! the arm carries the workpiece (IPO_FRAME #TCP), which is not supported",
          "XP6! BASE_DATA[3] is carried by an external axis",
          "XP1! is used before with another tool, base or configuration",
          "XFAR! the position is out of the arm's reach", "XP7 no motion goes to it"));
  EXPECT_EQ(corrected.done.changes.size(), 2U);
  EXPECT_EQ(corrected.done.changes[1].name, "XP4");
}

constexpr std::string_view kFrames = "DEF P()\nBAS(#TOOL,1)\nBAS(#BASE,2)\n";
constexpr std::string_view kPoint =
    "{X 489.7386,Y -315.4534,Z 893.6362,A 36.4564,B 72.0138,C 148.9511,S 2,T 34,E1 1.50}";

std::string program(std::string_view motions) { return std::string(kFrames).append(motions) + "END\n"; }

TEST(ProgramCompensation, ATargetOfUnknownToolOrBaseIsAFaultThatSaysWhatToGive) {
  const std::string lin = std::string("LIN ").append(kPoint) + "\n";
  const auto fault = [&](const std::string& start) {
    return Corrected("DEF P()\n" + start + lin + "END\n", "").fault;
  };
  EXPECT_EQ(
      fault("BAS(#BASE,2)\n"),
      "the program does not set the tool of this motion. Set it before with $TOOL or BAS(#TOOL,n), or give "
      "--tool x,y,z,a,b,c with --program.");
  EXPECT_EQ(
      fault("BAS(#TOOL,1)\n"),
      "the program does not set the base of this motion. Set it before with $BASE or BAS(#BASE,n), or give "
      "--base x,y,z,a,b,c with --program.");
  EXPECT_EQ(fault("BAS(#TOOL,7)\nBAS(#BASE,2)\n"),
            "TOOL_DATA[7] is not known. Give a $config.dat that has it (--config-dat).");
  EXPECT_EQ(Corrected("DEF P()\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 30,A6 0}\n", "").fault, "");
}

TEST(ProgramCompensation, AComputedToolOrBaseLeavesItsTargetsAlone) {
  const Corrected corrected(program(std::string("$BASE=SHIFTED(1)\nLIN ").append(kPoint) + "\n"), "");
  EXPECT_THAT(corrected.left(), ElementsAre("! the base is computed by the program"));
}

TEST(ProgramCompensation, AToolOrBaseThatTheProgramWritesLeavesItsTargetsAloneAndNamesTheStatement) {
  const std::string lin = std::string("LIN ").append(kPoint) + "\n";
  for (const auto& [write, why] :
       {std::pair{"BASE_DATA[2].Z=750.0", "BASE_DATA[2] is written by the program"},
        std::pair{"TOOL_DATA[N]={X 1,Y 2,Z 3,A 4,B 5,C 6}", "TOOL_DATA[1] is written by the program"}}) {
    const Corrected corrected("DEF P()\n" + std::string(write) + "\nBAS(#TOOL,1)\nBAS(#BASE,2)\n" + lin, "");
    EXPECT_EQ(corrected.after.src, corrected.before.src);
    ASSERT_THAT(corrected.left(), ElementsAre(std::string("! ") + why));
    ASSERT_TRUE(corrected.done.left[0].why.because);
    EXPECT_EQ(corrected.done.left[0].why.because->at, corrected.before.src.find(write));
  }
}

TEST(ProgramCompensation, ASecondUseWithTheSameFramesIsNoConflict) {
  const std::string dat = std::string("E6POS XP1=").append(kPoint) + "\n";
  const Corrected corrected(program("LIN XP1\n$TOOL=TOOL_DATA[1]\nPTP XP1\n"), dat);
  EXPECT_THAT(corrected.left(), IsEmpty());
  EXPECT_EQ(corrected.done.changes.size(), 1U);
  EXPECT_THAT(corrected.after.dat, HasSubstr("S 2,T 34,E1 1.50}"));
}

std::string axes(const JointVector& q) {
  std::ostringstream text;
  text.precision(12);
  for (Eigen::Index i = 0; i < 6; ++i) text << (i ? ",A" : "{A") << i + 1 << " " << q[i] * kDegPerRad;
  return text.str() + "}";
}

std::string cartesian(const JointVector& q, int status, int turn) {
  const Eigen::Isometry3d X = forward_kinematics(kNominal, q);
  const Eigen::Vector3d abc = kuka_abc_deg(X.linear());
  std::ostringstream text;
  text.precision(12);
  text << "{X " << X(0, 3) << ",Y " << X(1, 3) << ",Z " << X(2, 3) << ",A " << abc.x() << ",B " << abc.y()
       << ",C " << abc.z() << ",S " << status << ",T " << turn << "}";
  return text.str();
}

JointVector deg(std::initializer_list<double> values) {
  JointVector q(6);
  std::ranges::copy(values, q.begin());
  return q * kRadPerDeg;
}

const std::string kFlange = "DEF P()\n$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\n";

void expect_bits_of(const JointVector& q, const RobotModel& real, bool status_changes, bool turn_changes) {
  // Bit 4 of S, which a controller with KUKA's own accuracy model sets, stays.
  const int status = oracle::status(q) + 16, turn = oracle::turn(q);
  const Corrected corrected(kFlange + "PTP " + cartesian(q, status, turn) + "\n", "", real);
  ASSERT_EQ(corrected.done.changes.size(), 1U);
  const krl::Position& after = corrected.program_after.points[0].position;
  const JointVector q_real = TargetCompensation(kNominal, real).at_joints(q)->q;
  EXPECT_EQ(static_cast<int>(after.status->value), oracle::status(q_real) + 16);
  EXPECT_EQ(static_cast<int>(after.turn->value), oracle::turn(q_real));
  EXPECT_EQ(after.status->value != status, status_changes);
  EXPECT_EQ(after.turn->value != turn, turn_changes);
  EXPECT_EQ(corrected.done.notes.size(), static_cast<std::size_t>(1 + status_changes + turn_changes));
  EXPECT_THAT(corrected.done.notes[0].text, HasSubstr("KUKA's own accuracy model"));
}

TEST(ProgramCompensation, TurnFollowsAnAxisAcrossItsBoundaryAndThatIsSaid) {
  const JointVector q = deg({0.02, -95, 100, 20, 40, 30});
  RobotModel off = kNominal;
  off.joints[0].theta_rad += 0.1 * kRadPerDeg;
  expect_bits_of(q, off, false, false);
  off.joints[0].theta_rad -= 0.2 * kRadPerDeg;
  expect_bits_of(q, off, false, true);
}

TEST(ProgramCompensation, StatusFollowsAxis5AcrossZero) {
  RobotModel off = kNominal;
  off.joints[4].theta_rad += 0.1 * kRadPerDeg;
  expect_bits_of(deg({10, -95, 100, 20, 0.02, 30}), off, true, true);
  expect_bits_of(deg({10, -95, 100, 20, 0.2, 30}), off, false, false);
}

TEST(ProgramCompensation, NearTheWristSingularityTheTcpIsCorrectedAndWhatIsLeftOfTheOrientationIsSaid) {
  const JointVector q = deg({10, -95, 100, 20, 0.2, 30});
  const Corrected corrected(kFlange + "PTP " + cartesian(q, 2, 2) + "\n", "");
  EXPECT_THAT(corrected.left(), IsEmpty());
  ASSERT_EQ(corrected.done.changes.size(), 1U);
  ASSERT_EQ(corrected.done.notes.size(), 1U);
  EXPECT_THAT(corrected.done.notes[0].text, HasSubstr("next to the wrist singularity"));
}

TEST(ProgramCompensation, WhatCannotBeDoneWellIsLeftAlone) {
  const auto left = [](const std::string& target) {
    return Corrected(kFlange + "PTP " + target + "\n", "", kReal, kExact).left();
  };
  EXPECT_THAT(left(cartesian(deg({10, -95, 100, 20, 0.2, 30}), 2, 2)),
              ElementsAre(HasSubstr("too near to a singularity")));
  EXPECT_THAT(left(axes(deg({0, -90, 90, 0, 30, 349.999}))).size() +
                  left(axes(deg({0, -90, 90, 0, 30, -349.999}))).size(),
              1U);
  EXPECT_THAT(left(axes(deg({0, -90, 90, 0, 30, 355}))), ElementsAre(HasSubstr("its limits are -350..350")));
  EXPECT_THAT(left(cartesian(deg({10, -95, 100, 20, 30, 30}), 2, 63)),
              ElementsAre("! the arm cannot take the position with S 2 and T 63 within its joint limits"));
  EXPECT_THAT(left("{X 1E300,Y 0,Z 0,A 0,B 0,C 0,S 2,T 2}"), ElementsAre(HasSubstr("!")));
  EXPECT_THAT(left("{A1 1E300,A2 0,A3 0,A4 0,A5 0,A6 0}"), ElementsAre(HasSubstr("!")));
}

TEST(HindranceKinds, AreAllProvoked) {
  RobotModel far_off = kNominal;
  far_off.joints[0].theta_rad += 3 * kRadPerDeg;
  const std::string point = "{X 1500,Y 0,Z 1500,A 0,B 90,C 0,S 2,T 2}", ptp = "PTP " + point + "\n";
  const std::string given = "DEF P()\nDECL POS P\nDECL POS Q[2]\n$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\n";
  std::set<std::string> codes;
  const auto provoke = [&](const std::string& src, const std::string& dat = {},
                           const RobotModel& real = kReal, bool is_archive = false) {
    const krl_corpus::Files files{"p", src, dat,
                                  krl_corpus::bytes("config.dat") + "E6POS GPOINT=" + point + "\n"};
    const auto inverse = StatusTurnInverse::of(kNominal).value();
    const auto done = compensate_program(krl::read_program(files.text(), {}).value(), kNominal, inverse, real,
                                         kExact, {}, is_archive);
    ASSERT_TRUE(done) << done.error().what << src;
    for (const krl::LeftAlone& left : done->left) codes.insert(left.why.message.code);
  };
  provoke(krl_corpus::bytes("computed.src"), krl_corpus::bytes("computed.dat"));
  for (const char* motion :
       {"CIRC {A1 0},{A1 0},CA 90\n", "PTP {X 1,Y 0,Z 0,A 0,B 0,C 0,S 1.5}\n",
        "PTP {X 1,Y 0,Z 0,A 0,B 0,C I}\n", "PTP P\n", "PTP Q[I]\nQ[1]={X 1,Y 0,Z 0,A 0,B 0,C 0}\nPTP Q[1]\n",
        "PTP P+1\n", "PTP GPOINT\n",
        "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $BASE=X\nPTP {X 1,Y 0,Z 0,A 0,B 0,C 0}\n",
        "PTP {X 1,Y 0,Z 0,A 0,B 0,C 0}\n", "PTP ELSEWHERE\nLIN_REL {X 1}\n",
        "PTP {A1 355,A2 -90,A3 90,A4 0,A5 30,A6 0}\n"})
    provoke(given + motion);
  provoke(given + "PTP " + cartesian(deg({10, -95, 100, 20, 30, 30}), 2, 63) + "\n");
  provoke(given + "PTP {X 9000,Y 0,Z 0,A 0,B 0,C 0,S 2,T 2}\nLIN_REL {X 1}\n");
  provoke(given + "PTP " + axes(deg({10, -95, 100, 20, 30, 30})) + "\n", "", far_off);
  provoke("DEF P()\n" + ptp, "", kReal, true);
  provoke("DEF P()\nBAS(#TOOL,7)\n" + ptp, "", kReal, true);
  provoke("DEF P()\nTOOL_DATA[1]={X 1,Y 2,Z 3,A 4,B 5,C 6}\nBAS(#TOOL,1)\nBAS(#BASE,2)\n" + ptp);
  for (const MessageKind& kind : krl::kHindranceKinds)
    EXPECT_TRUE(codes.contains(std::string{kind.code})) << kind.code;
}

TEST(ProgramCompensation, WithoutStatusAndTurnTheTargetBeforeDecides) {
  const std::string without = std::string(kPoint.substr(0, kPoint.find(",S "))) + "}";
  const Corrected first(program("LIN " + without + "\n"), "");
  EXPECT_THAT(first.left(),
              ElementsAre("! S and T are not both given, and where the arm comes from is not known"));
  const Corrected after_home(program("PTP XHOME\nLIN " + without + "\nLIN " + without + "\n"), "");
  EXPECT_THAT(after_home.left(), ElementsAre("XHOME is a home position of the cell"));
  EXPECT_EQ(after_home.done.changes.size(), 2U);
  ASSERT_EQ(after_home.done.notes.size(), 1U);
  EXPECT_THAT(after_home.done.notes[0].text, HasSubstr("S and T are missing"));
  const Corrected after_unknown(program("PTP XHOME\nPTP ELSEWHERE\nLIN " + without + "\n"), "");
  EXPECT_EQ(after_unknown.done.changes.size(), 0U);
}

TEST(ProgramCompensation, RandomPositionsOfAllKindsLandWhereTheyShould) {
  Random random(7);
  std::string motions = kFlange + "BAS(#TOOL,1)\nBAS(#BASE,2)\n", dat;
  const std::string config = krl_corpus::bytes("config.dat");
  const krl::FrameData frames = krl::frame_data_of(*krl::read_statements(config));
  const Eigen::Isometry3d X_tool = frames.tools.at(1), X_base = frames.bases.at(2);
  for (int i = 0; i < 500; ++i) {
    JointVector q(6);
    for (std::size_t k = 0; k < 6; ++k) {
      const Joint& joint = kNominal.joints[k];
      q[static_cast<Eigen::Index>(k)] = random.uniform(joint.min + 0.05, joint.max - 0.05);
    }
    const Eigen::Isometry3d X = X_base.inverse() * forward_kinematics(kNominal, q) * X_tool;
    const Eigen::Vector3d abc = kuka_abc_deg(X.linear());
    std::ostringstream line;
    line.precision(9);
    line << "E6POS X" << i << "={X " << X(0, 3) << ",Y " << X(1, 3) << ",Z " << X(2, 3) << ",A " << abc.x()
         << ",B " << abc.y() << ",C " << abc.z() << ",S " << oracle::status(q) << ",T " << oracle::turn(q)
         << "}\nE6AXIS J" << i << "=" << axes(q) << "\n";
    dat += line.str();
    motions += "PTP X" + std::to_string(i) + "\nPTP J" + std::to_string(i) + "\n";
  }
  const Corrected corrected(motions, dat, kReal, kExact);
  ASSERT_EQ(corrected.fault, "");
  // Near a wrist singularity, at the reach's end and at limits there is nothing to correct to.
  EXPECT_GT(corrected.done.changes.size(), 800U);
  Corrected kept = corrected;
  std::erase_if(kept.program.steps, [&](const krl::Step& step) {
    return step.point && std::ranges::any_of(corrected.done.left, [&](const krl::LeftAlone& left) {
             return left.name == corrected.program.points[*step.point].name;
           });
  });
  kept.program_after.steps = kept.program.steps;
  EXPECT_EQ(static_cast<std::size_t>(expect_the_real_arm_where_the_nominal_one_was(kept)),
            corrected.done.changes.size());
}

}  // namespace
}  // namespace truepose::tools
