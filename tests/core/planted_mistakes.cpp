#include "tests/core/planted_mistakes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/random.hpp"

namespace truepose::example {
namespace {

constexpr double kDeg = std::numbers::pi / 180;

std::string of_joint(std::size_t i) { return "joint " + std::to_string(i + 1); }

class Mistakes {
 public:
  Mistakes(const RobotModel& robot, int poses, std::uint64_t seed)
      : robot_{robot}, poses_{poses}, random_{seed} {}

  std::vector<PlantedMistake> all() && {
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) of_row(i);
    of_robot_file();
    of_columns();
    of_rows();
    return std::move(all_);
  }

 private:
  void add(std::string name, std::string words, std::function<void(Files&)> make) {
    all_.push_back({std::move(name), std::move(words), std::move(make)});
  }
  void in_joint(std::string name, std::size_t i, std::string words, std::function<void(Joint&)> make) {
    add(name + ' ' + std::to_string(i + 1), std::move(words),
        [i, make = std::move(make)](Files& files) { make(files.robot.joints[i]); });
  }
  void in_points(std::string name, std::string words, std::function<void(Measurement&)> make) {
    add(std::move(name), std::move(words), [make = std::move(make)](Files& files) {
      for (Measurement& point : files.data.points) make(point);
    });
  }

  void of_row(std::size_t i) {
    const Joint& joint = robot_.joints[i];
    const bool turns = joint.type == JointType::Revolute;
    in_joint("sign", i, of_joint(i) + (turns ? " turns" : " moves") + " the other way",
             [](Joint& j) { j.sign = -j.sign; });
    const double right = std::array{90., -90., 180.}[static_cast<std::size_t>(random_.uniform(0, 3))];
    in_joint("right-angle", i,
             "theta of " + of_joint(i) + " is off by " + std::to_string(static_cast<int>(right)),
             [right](Joint& j) { j.theta_rad += right * kDeg; });
    const double any = std::copysign(random_.uniform(5, 80), random_.uniform(-1, 1));
    in_joint("zero", i, "theta of " + of_joint(i) + " is off by ",
             [any](Joint& j) { j.theta_rad += any * kDeg; });
    const double off = std::copysign(random_.uniform(15, 500), random_.uniform(-1, 1));
    in_joint("a", i, "a of " + of_joint(i) + " is off by ", [off](Joint& j) { j.a_mm += off; });
    in_joint("d", i, "d of " + of_joint(i) + " is off by ", [off](Joint& j) { j.d_mm += off; });
    if (std::abs(joint.a_mm - joint.d_mm) > 15) {
      in_joint("swapped-a-d", i, "a and d of " + of_joint(i) + " are swapped",
               [](Joint& j) { std::swap(j.a_mm, j.d_mm); });
    }
    if (std::abs(std::sin(joint.alpha_rad)) > 0.5) {
      in_joint("alpha", i, "alpha of " + of_joint(i) + " has the wrong sign",
               [](Joint& j) { j.alpha_rad = -j.alpha_rad; });
    }
    if (i > 0 && turns && robot_.joints[i - 1].type == JointType::Revolute) {
      const double factor = random_.uniform() < 0.5 ? 1 : -1;
      in_points(
          "coupled " + std::to_string(i + 1), of_joint(i) + " is coupled to " + of_joint(i - 1),
          [k = static_cast<Eigen::Index>(i), factor](Measurement& m) { m.q[k] -= factor * m.q[k - 1]; });
    }
  }

  void of_robot_file() {
    add("standard-dh", "as in standard DH", [](Files& files) {
      std::vector<Joint>& joints = files.robot.joints;
      for (std::size_t i = 0; i + 1 < joints.size(); ++i) {
        joints[i].a_mm = joints[i + 1].a_mm;
        joints[i].alpha_rad = joints[i + 1].alpha_rad;
      }
      joints.back().a_mm = joints.back().alpha_rad = 0;
    });
    add("late-rows", "a and alpha stand one row too late", [](Files& files) {
      std::vector<Joint>& joints = files.robot.joints;
      for (std::size_t i = joints.size() - 1; i > 0; --i) {
        joints[i].a_mm = joints[i - 1].a_mm;
        joints[i].alpha_rad = joints[i - 1].alpha_rad;
      }
    });
    add("robot-rad", "the angles of the robot file are in rad", [](Files& files) {
      for (Joint& j : files.robot.joints) {
        j.alpha_rad *= kDeg;
        j.theta_rad *= kDeg;
      }
    });
    for (const auto& [name, mm] : {std::pair{"m", 1000.0}, std::pair{"inches", 25.4}}) {
      add(std::string{"robot-"} + name, std::string{"the lengths of the robot file are in "} + name,
          [mm](Files& files) {
            for (Joint& j : files.robot.joints) {
              j.a_mm /= mm;
              j.d_mm /= mm;
            }
          });
      in_points(std::string{"points-"} + name, std::string{"the points are in "} + name,
                [mm](Measurement& m) { m.p_WS_mm /= mm; });
    }
  }

  void of_columns() {
    in_points("joints-rad", "the joint angles of the measurements are in rad",
              [this_ = robot_](Measurement& m) {
                for (std::size_t i = 0; i < this_.joints.size(); ++i) {
                  if (this_.joints[i].type == JointType::Revolute) m.q[static_cast<Eigen::Index>(i)] *= kDeg;
                }
              });
    const auto n = static_cast<double>(robot_.joints.size());
    const auto i = static_cast<Eigen::Index>(random_.uniform(0, n - 1));
    const auto j = static_cast<Eigen::Index>(random_.uniform(static_cast<double>(i) + 1, n));
    in_points("swapped-q " + std::to_string(i + 1) + std::to_string(j + 1),
              "the columns q" + std::to_string(i + 1) + " and q" + std::to_string(j + 1),
              [i, j](Measurement& m) { std::swap(m.q[i], m.q[j]); });
    in_points("reversed-q", "in reversed order",
              [](Measurement& m) { std::reverse(m.q.data(), m.q.data() + m.q.size()); });
    const int axis = static_cast<int>(random_.uniform(0, 3));
    in_points("swapped-xyz", "left-handed",
              [axis](Measurement& m) { std::swap(m.p_WS_mm[axis], m.p_WS_mm[(axis + 1) % 3]); });
    in_points("mirrored", "left-handed", [axis](Measurement& m) { m.p_WS_mm[axis] *= -1; });
  }

  void of_rows() {
    for (const int by : {1, -1, 2, -3}) {
      add("shifted " + std::to_string(by), "than their joints", [by](Files& files) {
        std::vector<Measurement> moved;
        const std::vector<Measurement>& all = files.data.points;
        const int count = static_cast<int>(all.size());
        for (int i = std::max(0, by); i < std::min(count, count + by); ++i) {
          Measurement m = all[static_cast<std::size_t>(i)];
          m.p_WS_mm = all[static_cast<std::size_t>(i - by)].p_WS_mm;
          moved.push_back(m);
        }
        files.data.points = moved;
      });
    }
    const int at = static_cast<int>(random_.uniform(0.2, 0.8) * poses_);
    for (const bool point : {true, false}) {
      const std::string row = std::to_string(at + 1);
      add((point ? "missing-point " : "missing-joints ") + row,
          (point ? "a point is missing" : "a joint position is missing"), [at, point](Files& files) {
            std::vector<Measurement>& all = files.data.points;
            for (int i = at; i + 1 < static_cast<int>(all.size()); ++i) {
              const auto k = static_cast<std::size_t>(i);
              if (point) {
                all[k].p_WS_mm = all[k + 1].p_WS_mm;
              } else {
                all[k].q = all[k + 1].q;
              }
            }
            all.pop_back();
          });
    }
    const std::uint64_t seed = random_.next();
    add("shuffled", "in another order", [seed](Files& files) {
      Random random{seed};
      std::vector<Measurement>& all = files.data.points;
      for (std::size_t k = all.size() - 1; k > 0; --k)
        std::swap(all[k].p_WS_mm,
                  all[static_cast<std::size_t>(random.uniform(0, static_cast<double>(k) + 1))].p_WS_mm);
    });
  }

  RobotModel robot_;
  int poses_;
  Random random_;
  std::vector<PlantedMistake> all_;
};

}  // namespace

std::vector<PlantedMistake> mistakes_of(const RobotModel& robot, int poses, std::uint64_t seed) {
  return Mistakes{robot, poses, seed}.all();
}

}  // namespace truepose::example
