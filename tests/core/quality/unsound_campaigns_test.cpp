// What the verdict says of campaigns in which something is wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"
#include "tests/core/quality/drawn_campaign.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

/// A campaign on a KR 210 that nothing is wrong with.
DrawnCell plain_cell(std::uint64_t seed) {
  DrawnCell cell{.random = Random{seed + 90'000},
                 .nominal = example::kr210(),
                 .truth = {},
                 .options = {},
                 .before = {},
                 .spoil = {}};
  Random& random = cell.random;
  cell.truth.robot = example::deviating(cell.nominal, random, 0.3, 0.3e-3);
  cell.truth.repeatability_mm = 0.015;
  cell.truth.X_WB.translation() = Eigen::Vector3d(3500, random.uniform(-500, 500), -300);
  cell.truth.X_WB.rotate(Eigen::AngleAxisd{random.uniform(-3, 3), Eigen::Vector3d::UnitZ()});
  cell.truth.p_FS_mm = {random.uniform(80, 150), random.uniform(-100, 100), random.uniform(80, 200)};
  cell.identify = 40;
  cell.validate = 20;
  return cell;
}

/// What can be wrong, and what has to be said of it: one of these words.
struct Kind {
  std::string_view name;
  std::vector<std::string_view> words;
  std::function<void(DrawnCell&)> make;
};

using Rows = std::vector<Measurement>;

template <typename Each>
void from_row_on(Rows& rows, std::size_t first, Each each) {
  for (std::size_t i = first; i < rows.size(); ++i) each(rows[i]);
}

std::size_t some_row(const Rows& rows, Random& random, double from = 0.3, double to = 0.7) {
  return static_cast<std::size_t>(random.uniform(from, to) * static_cast<double>(rows.size()));
}

std::vector<Kind> kinds() {
  const auto at_share = [](int point, int of, double share) { return point == static_cast<int>(share * of); };
  const auto spoiled = [](auto spoil) { return [spoil](DrawnCell& cell) { cell.spoil = spoil; }; };
  const auto rows = [=](auto spoil) {
    return spoiled([spoil](MeasurementData& data, Random&) { std::ranges::for_each(data.points, spoil); });
  };
  const auto from_some_row_on = [=](auto spoil) {
    return spoiled([spoil](MeasurementData& data, Random& random) {
      from_row_on(data.points, some_row(data.points, random), spoil);
    });
  };
  std::vector<Kind> all;
  const auto add = [&](std::string_view name, std::vector<std::string_view> words,
                       std::function<void(DrawnCell&)> make) {
    all.push_back({name, std::move(words), [=](DrawnCell& cell) {
                     cell.in_order = true;
                     make(cell);
                   }});
  };
  for (const double way_mm : {0.3, 3.0}) {
    add("reflector moved", {"reflector '1' was exchanged or moved"}, [=](DrawnCell& cell) {
      cell.before = [=](TrueArm& arm, TrueArmSetup&, int point, int of) {
        if (at_share(point, of, 0.5))
          arm.put_reflector(arm.setup().p_FS_mm + way_mm * Eigen::Vector3d(0.6, 0, 0.8));
      };
    });
    add("reflector loosens", {"reflector '1' was exchanged or moved"}, [=](DrawnCell& cell) {
      const double all_points = cell.identify + cell.validate;
      cell.before = [=](TrueArm& arm, TrueArmSetup&, int, int) {
        arm.put_reflector(arm.setup().p_FS_mm + way_mm / all_points * Eigen::Vector3d(0.6, 0, 0.8));
      };
    });
    add("tracker moved", {"the tracker or the base moved"}, [=](DrawnCell& cell) {
      cell.before = [=](TrueArm&, TrueArmSetup& truth, int point, int of) {
        if (at_share(point, of, 0.4)) truth.X_WB.translation() += way_mm * Eigen::Vector3d(0.6, 0, 0.8);
      };
    });
    add("tracker creeps", {"the tracker or the base moved"}, [=](DrawnCell& cell) {
      const double all_points = cell.identify + cell.validate;
      cell.before = [=](TrueArm&, TrueArmSetup& truth, int, int) {
        truth.X_WB.translation() += way_mm / all_points * Eigen::Vector3d(0.6, 0, 0.8);
      };
    });
  }
  for (const double jump_deg : {0.02, 0.1})
    add("encoder slipped",
        {"offset of joint 2 changed", "offset of joint 3 changed", "joint 2's", "times the noise"},
        [=](DrawnCell& cell) {
          cell.spoil = [=](MeasurementData& data, Random&) {
            from_row_on(data.points, 2 * data.points.size() / 5,
                        [=](Measurement& m) { m.q[1] += turn(jump_deg); });
          };
        });
  add("all axes mastered again",
      {"encoder offset", "mastered", "times the noise", "the validation points are off"},
      [](DrawnCell& cell) {
        cell.spoil = [](MeasurementData& data, Random& random) {
          JointVector step(6);
          for (double& each : step) each = turn(0.01) * random.normal();
          from_row_on(data.points, data.points.size() / 2, [=](Measurement& m) { m.q += step; });
        };
      });
  add("payload changed", {"the load on the flange changed"}, [at_share](DrawnCell& cell) {
    cell.truth.non_geometric = heavy_arm_errors({.payload_kg = 0, .harmonics = false});
    cell.options.non_geometric = true;
    cell.before = [=](TrueArm& arm, TrueArmSetup&, int point, int of) {
      if (!at_share(point, of, 0.5)) return;
      TrueArmSetup loaded = arm.setup();
      loaded.non_geometric = heavy_arm_errors({.payload_kg = 200, .harmonics = false});
      arm = TrueArm{loaded, 5};
    };
  });
  add("geometry alone, heavy arm", {"--non-geometric auto"},
      [](DrawnCell& cell) { cell.truth.non_geometric = heavy_arm_errors({}); });
  add("one reading wrong", {"contradict the others", "beyond six sigma"},
      spoiled([](MeasurementData& data, Random& random) {
        data.points[some_row(data.points, random, 0, 1)].p_WS_mm +=
            Eigen::Vector3d(0.6, 0, 0.8) * random.uniform(0.5, 20);
      }));
  add("readings wrong", {"contradict the others", "beyond six sigma"},
      spoiled([](MeasurementData& data, Random& random) {
        for (int n = 0; n < 3; ++n)
          data.points[some_row(data.points, random, 0, 1)].p_WS_mm +=
              Eigen::Vector3d(0.6, 0, 0.8) * random.uniform(1, 20);
      }));
  add("stale joints", {"contradict the others", "beyond six sigma"},
      spoiled([](MeasurementData& data, Random& random) {
        const std::size_t row = some_row(data.points, random);
        for (std::size_t i = row + 1; i-- > row - 1;) data.points[i].q = data.points[i - 1].q;
      }));
  add("many stale joints", {"the same joints are given"}, spoiled([](MeasurementData& data, Random& random) {
        for (int n = 0; n < 15; ++n) {
          const std::size_t row = some_row(data.points, random, 0.05, 1);
          data.points[row].q = data.points[row - 1].q;
        }
      }));
  add("joint typo", {"contradict the others", "beyond six sigma"},
      spoiled([](MeasurementData& data, Random& random) {
        data.points[some_row(data.points, random, 0, 1)].q[1] += turn(random.uniform(0.1, 0.9));
      }));
  for (const double step_deg : {0.1, 1.0})
    add("joints rounded", {"all joints are given to"}, [=](DrawnCell& cell) { cell.rounded_deg = step_deg; });
  add("positions rounded", {"times the noise", "more than"}, rows([](Measurement& m) {
        for (double& x : m.p_WS_mm) x = std::round(x);
      }));
  add("inches", {"inches"}, rows([](Measurement& m) { m.p_WS_mm /= 25.4; }));
  add("metres", {"metres", "in m,"}, rows([](Measurement& m) { m.p_WS_mm /= 1000; }));
  add("inches from a row on", {"from row"}, from_some_row_on([](Measurement& m) { m.p_WS_mm /= 25.4; }));
  add("metres from a row on", {"from row"}, from_some_row_on([](Measurement& m) { m.p_WS_mm /= 1000; }));
  add("second set-up in one file", {"from row", "tracker or the base moved"},
      spoiled([](MeasurementData& data, Random& random) {
        Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
        X.rotate(Eigen::AngleAxisd{random.uniform(0.3, 2), Eigen::Vector3d::UnitZ()});
        X.translation() = Eigen::Vector3d(random.uniform(500, 1500), random.uniform(500, 1500), 100);
        from_row_on(data.points, some_row(data.points, random),
                    [=](Measurement& m) { m.p_WS_mm = X * m.p_WS_mm; });
      }));
  add("longer link in the file", {"link2.a", "link 2", "a of joint 2", "joint 3"},
      [](DrawnCell& cell) { cell.nominal.joints[2].a_mm += 20; });
  add("longer forearm in the file", {"joint 4", "link4", "d"},
      [](DrawnCell& cell) { cell.nominal.joints[3].d_mm += 200; });
  add("sign in the file", {"sign"}, [](DrawnCell& cell) { cell.nominal.joints[2].sign *= -1; });
  add("columns swapped", {"swap", "q2", "q3", "column"},
      rows([](Measurement& m) { std::swap(m.q[1], m.q[2]); }));
  add("radians", {"radian", "degrees", "deg"}, rows([](Measurement& m) { m.q *= kRadPerDeg; }));
  add("five times the noise", {"times the noise", "off by"},
      [](DrawnCell& cell) { cell.true_noise_mm = 0.15; });
  add("twenty times the noise", {"times the noise"}, [](DrawnCell& cell) { cell.true_noise_mm = 0.5; });
  for (const double share : {0.03, 0.08, 0.15})
    add("narrow poses", {"less than a quarter of the range"}, [=](DrawnCell& cell) {
      cell.within = share;
      cell.truth.non_geometric = heavy_arm_errors({.compliance = false});
    });
  add("lengths grow at a moment", {"length", "warm"}, [=](DrawnCell& cell) {
    cell.before = [=](TrueArm& arm, TrueArmSetup&, int point, int of) {
      if (!at_share(point, of, 0.5)) return;
      TrueArmSetup grown = arm.setup();
      for (Joint& joint : grown.robot.joints) joint.a_mm *= 1 + 90e-6, joint.d_mm *= 1 + 90e-6;
      arm = TrueArm{grown, 6};
    };
  });
  add("no pose validates", {"nothing but the points"}, [](DrawnCell& cell) { cell.validate = 0; });
  add("two poses validate", {"little of all others"}, [](DrawnCell& cell) { cell.validate = 2; });
  add("validated on the same poses", {"nothing but the points"},
      spoiled([](MeasurementData& data, Random& random) {
        for (std::size_t i = 40; i < data.points.size(); ++i) {
          const Measurement& seen = data.points[i - 40];
          data.points[i].q = seen.q;
          data.points[i].p_WS_mm =
              seen.p_WS_mm + 0.02 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
        }
      }));
  add("rows copied", {"repeat the joints and the reading"}, spoiled([](MeasurementData& data, Random&) {
        for (std::size_t i = 0; i < 10; ++i) {
          data.points.push_back(data.points[i]);
          data.points.back().set = PoseSet::Identify;
        }
      }));
  add("tripod breathes", {"tracker or the base moved", "times the noise"}, [](DrawnCell& cell) {
    cell.before = [](TrueArm&, TrueArmSetup& truth, int point, int of) {
      truth.X_WB.translation().z() = -300 + 0.3 * std::sin(6.28 * point / of);
    };
  });
  add("labels of reflectors swapped", {"label", "reflector"}, [](DrawnCell& cell) {
    cell.truth.further = {{.p_FS_mm = {-100, 50, 80}}, {.p_FS_mm = {0, -120, 150}}};
    cell.spoil = [](MeasurementData& data, Random& random) {
      for (std::size_t i = 0; i + 2 < data.points.size(); i += 3)
        if (random.next() % 4 == 0) std::swap(data.points[i].p_WS_mm, data.points[i + 1].p_WS_mm);
    };
  });
  add("gear ratio", {"times the noise", "encoder offset", "off by"},
      rows([](Measurement& m) { m.q[1] *= 1.001; }));
  add("reflector on the last axis", {"on the axis of joint 6"}, [](DrawnCell& cell) {
    cell.truth.p_FS_mm = {0.02, 0, 200};
    cell.true_noise_mm = cell.noise_mm = 0.1;
  });
  add("loose reflector", {"times the noise", "reflector", "off by"}, [](DrawnCell& cell) {
    cell.before = [](TrueArm& arm, TrueArmSetup&, int point, int) {
      arm.put_reflector(Eigen::Vector3d(100, 20, 120) +
                        (point % 3 == 0 ? 0.8 : 0.0) * Eigen::Vector3d(0.6, 0, 0.8));
    };
  });
  return all;
}

TEST(VerdictOnUnsoundCampaigns, IsNeverGreenOfABadModelAndNamesTheReason) {
  const int runs = trials(250) / 10 + 1;
  int bad_green = 0, named = 0, all = 0, passed_bad = 0;
  for (const Kind& kind : kinds()) {
    int refused = 0, red = 0, amber = 0, advised = 0, green = 0, bad = 0, said = 0, bad_passed = 0;
    std::string otherwise;
    for (int run = 0; run < runs; ++run) {
      const auto seed = static_cast<std::uint64_t>(run) + 1;
      DrawnCell cell = plain_cell(seed);
      kind.make(cell);
      const JudgedCampaign made = judged(cell, seed);
      std::string text = made.refusal;
      for (const Finding& finding : made.verdict.findings)
        text += finding.sentence + ": " + finding.what_to_do + "; ";
      const bool is_said =
          std::ranges::any_of(kind.words, [&](std::string_view w) { return text.contains(w); });
      const bool is_green = !made.refused && made.verdict.color() == VerdictColor::Green;
      refused += made.refused;
      red += !made.refused && made.verdict.color() == VerdictColor::Red;
      amber += !made.refused && made.verdict.color() == VerdictColor::Amber && made.verdict.failed();
      advised += !made.refused && made.verdict.color() == VerdictColor::Amber && !made.verdict.failed();
      green += is_green;
      const double said_mm =
          made.refused ? 0
                       : std::max(made.calibration.transfer.rms_mm,
                                  made.calibration.validate ? made.calibration.validate->after.rms : 0);
      const bool is_bad = !made.refused && made.true_rms_mm > 2 * said_mm && made.true_rms_mm > 0.1;
      bad += is_bad && is_green;
      bad_passed += is_bad && !made.verdict.failed();
      // A model that is as good as it says does no harm.
      const bool right = is_said || (!is_bad && is_green);
      said += right;
      if (!right) otherwise = text;
    }
    std::cout << kind.name << ": refused " << refused << ", red " << red << ", doubt " << amber << ", advice "
              << advised << ", green " << green << " (bad " << bad << ", passed bad " << bad_passed
              << "), reason right " << said << " of " << runs
              << (otherwise.empty() ? "" : "; else: " + otherwise.substr(0, 300)) << '\n';
    bad_green += bad;
    passed_bad += bad_passed;
    named += said;
    all += runs;
  }
  std::cout << named << " of " << all << " named; passed bad " << passed_bad << '\n';
  EXPECT_EQ(bad_green, 0);
  EXPECT_GE(named, 0.95 * all);
}

}  // namespace
}  // namespace truepose
