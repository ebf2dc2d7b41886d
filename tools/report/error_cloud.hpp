#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace truepose::report {

/// An error at its place, mm in the robot's base frame.
struct CloudArrow {
  Eigen::Vector3d place{0, 0, 0}, error{0, 0, 0};
  std::string label;  ///< what a pointer resting on it reads
};

/// Error vectors in the workspace, seen from one side.
struct CloudView {
  std::string title;
  std::string id;  ///< unique on the page
  std::string color;
  double azimuth_rad = 0, elevation_rad = 0;  ///< of the eye; pi/2 looks down on the floor
  bool turns = false;                         ///< whether dragging turns it, by the page's script
};

/// What the views of one cloud have in common.
struct Cloud {
  std::vector<CloudArrow> arrows;       ///< at least one
  Eigen::Vector3d tracker_mm{0, 0, 0};  ///< in the base frame
  double exaggeration = 1;
};

/// A round factor by which the errors are well seen and do not hide each other.
double exaggeration_of(const std::vector<CloudArrow>& arrows);

/// The view as an <svg> element in 480 x 360 units: the arrows from the measured places, the robot's base as
/// its three axes on a grid of the floor, and the tracker; where that stands outside, its direction and
/// distance. What the script moves has its points as data-p and data-q (mm), and the element how it looks at
/// them.
std::string cloud_svg(const Cloud& cloud, const CloudView& view);

}  // namespace truepose::report
