#include "core/kernels/lane_frames.hpp"
#include "core/kernels/table.hpp"

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {
namespace {

/// The scaled local columns of up to kChunk points: three coordinates of `points` numbers each.
struct Chunk {
  double* columns;
  int points;

  double* column(int c) const { return columns + 3 * kChunk * c; }
  void put(int c, int at, const Lane3& value) const {
    double* const to = column(c) + at;
    store(to, value.x);
    store(to + points, value.y);
    store(to + 2 * points, value.z);
  }
};

/// The frames of the arm's links, of the base (0) to the last joint's, in kLanes points.
using LaneFrames = LaneFrame[kMostLinks + 1];

/// @param k  first of the points
void link_frames(const Arm& arm, const PointBlock& points, int k, LaneFrames& X) {
  X[0] = base_frame();
  for (int i = 0; i < arm.joints; ++i) {
    const Link& link = arm.link[i];
    LaneFrame& after = X[i + 1];
    after = X[i];
    cross_link(after, link);
    const Vec first = load(points.first + i * points.stride + k);
    if (arm.turn[i] != 0) {
      const Vec sine = load(points.second + i * points.stride + k);
      turn(after.x, after.y, sine * link.cos_theta + first * link.sin_theta,
           first * link.cos_theta - sine * link.sin_theta);
      after.p = after.p + after.z * link.d_mm;
    } else {
      turn(after.x, after.y, link.sin_theta, link.cos_theta);
      after.p = after.p + after.z * (first + link.d_mm);
    }
  }
}

/// What multiplies a vector of the base frame before it counts: a weight.
struct Weight {
  Vec w;

  Weight(const PointModel&, const PointBlock& points, int k) : w{load(points.weight + k)} {}
  Lane3 operator()(const Lane3& v) const { return v * w; }
};

/// Or the matrix that whitens in the tracker frame, times the base's rotation.
struct Whitening {
  Lane3 row[3];

  Whitening(const PointModel& model, const PointBlock& points, int k) {
    Vec U[6];
    for (int i = 0; i < 6; ++i) U[i] = load(points.whitening[i] + k);
    const double* const R = model.rotation;
    const auto turned = [R](Vec x, Vec y, Vec z) {
      return Lane3{x * R[0] + y * R[1] + z * R[2], x * R[3] + y * R[4] + z * R[5],
                   x * R[6] + y * R[7] + z * R[8]};
    };
    row[0] = turned(U[0], U[1], U[2]);
    row[1] = turned(Vec{}, U[3], U[4]);
    row[2] = turned(Vec{}, Vec{}, U[5]);
  }
  Lane3 operator()(const Lane3& v) const { return {dot(row[0], v), dot(row[1], v), dot(row[2], v)}; }
};

/// Derivative of the point P to a parameter of link `column.link`; see measurement_model.cpp for where these
/// come from.
Lane3 derivative(const PointModel& model, const LinkColumn& column, const LaneFrames& X, const Lane3& P) {
  const LaneFrame &before = X[column.link], &after = X[column.link + 1];
  const Link& link = model.arm->link[column.link];
  switch (column.kind) {
    case ColumnKind::A:
      return common_normal(before, link);
    case ColumnKind::Alpha:
      return cross(common_normal(before, link), P - before.p);
    case ColumnKind::D:
      return after.z;
    case ColumnKind::Theta:
      return cross(after.z, P - after.p);
    case ColumnKind::Beta:
      return cross(before.y, P - before.p);
  }
  __builtin_unreachable();
}

/// Fills the columns of the points from k on, in the base frame.
template <typename Scale>
void linearise(const PointModel& model, const PointBlock& points, int k, const Chunk& chunk) {
  const Arm& arm = *model.arm;
  for (int at = 0; at < chunk.points; at += kLanes) {
    LaneFrames X;
    link_frames(arm, points, k + at, X);
    const LaneFrame flange = flange_frame(X[arm.joints], arm);
    const Lane3 P = along(flange, model.reflector) + flange.p;
    const Scale scaled(model, points, k + at);

    const Lane3 from_base{load(points.measured[0] + k + at) - model.origin[0],
                          load(points.measured[1] + k + at) - model.origin[1],
                          load(points.measured[2] + k + at) - model.origin[2]};
    const auto base_axis = [&](const double* e) {
      return from_base.x * e[0] + from_base.y * e[1] + from_base.z * e[2];
    };
    const Lane3 measured{base_axis(model.rotation), base_axis(model.rotation + 3),
                         base_axis(model.rotation + 6)};
    chunk.put(0, at, scaled(P - measured));

    chunk.put(1, at, scaled({Vec{}, -P.z, P.y}));
    chunk.put(2, at, scaled({P.z, Vec{}, -P.x}));
    chunk.put(3, at, scaled({-P.y, P.x, Vec{}}));
    chunk.put(4, at, scaled(flange.x));
    chunk.put(5, at, scaled(flange.y));
    chunk.put(6, at, scaled(flange.z));
    for (int c = 0; c < model.column_count; ++c) {
      const LinkColumn& column = model.columns[c];
      Lane3 value = derivative(model, column, X, P);
      if (column.term >= 0) value = value * load(points.basis + column.term * points.stride + k + at);
      chunk.put(kFixedColumns + c, at, scaled(value));
    }
  }
}

/// The translations' columns of the points from k on: the base's axes.
void add_translations(const PointModel& model, const PointBlock& points, int k, const Chunk& chunk) {
  const int first = kFixedColumns + model.column_count;
  for (int at = 0; at < chunk.points; at += kLanes) {
    const Whitening whitened(model, points, k + at);
    const Vec one = all(1), zero{};
    chunk.put(first, at, whitened({one, zero, zero}));
    chunk.put(first + 1, at, whitened({zero, one, zero}));
    chunk.put(first + 2, at, whitened({zero, zero, one}));
  }
}

/// Rows and columns of the product that are summed at a time: as many as there are registers for.
inline constexpr int kBlockRows = kLanes == 8 ? 4 : kLanes == 4 ? 3 : 2;
inline constexpr int kBlockColumns = kBlock;

/// Adds the dot products of the columns i and j on, kBlockRows by kBlockColumns of them. Columns beyond the
/// last stand for it; their products are not regarded.
void add_block(const Chunk& chunk, int i, int j, int count, PointSums& sums_out) {
  const double *rows[kBlockRows], *columns[kBlockColumns];
  for (int r = 0; r < kBlockRows; ++r) rows[r] = chunk.column(i + r < count ? i + r : count - 1);
  for (int c = 0; c < kBlockColumns; ++c) columns[c] = chunk.column(j + c < count ? j + c : count - 1);

  Vec products[kBlockRows * kBlockColumns] = {};
  for (int k = 0; k < 3 * chunk.points; k += kLanes) {
    Vec left[kBlockRows];
#pragma GCC unroll 4
    for (int r = 0; r < kBlockRows; ++r) left[r] = load(rows[r] + k);
#pragma GCC unroll 4
    for (int c = 0; c < kBlockColumns; ++c) {
      const Vec right = load(columns[c] + k);
#pragma GCC unroll 4
      for (int r = 0; r < kBlockRows; ++r) products[r * kBlockColumns + c] += left[r] * right;
    }
  }

  alignas(64) double block[kBlockRows * kBlockColumns];
#pragma GCC unroll 8
  for (int k = 0; k < kBlockRows * kBlockColumns; k += kLanes) store(block + k, sums(products + k));
  for (int r = 0; r < kBlockRows; ++r) {
    double* const to = sums_out.gram + (i + r) * sums_out.stride + j;
    store4(to, load4(to) + load4(block + r * kBlockColumns));
  }
}

void add_gram(const Chunk& chunk, int count, PointSums& out) {
  for (int i = 0; i < count; i += kBlockRows)
    for (int j = i; j < count; j += kBlockColumns) add_block(chunk, i, j, count, out);
}

/// The sums that the base's translation makes where points are weighed: its columns are the axes themselves.
void sum_columns(const Chunk& chunk, const double* weight, int count, Vec (*lane_sums)[3]) {
  for (int c = 0; c < count; ++c) {
    for (int axis = 0; axis < 3; ++axis) {
      const double* const column = chunk.column(c) + axis * chunk.points;
      for (int k = 0; k < chunk.points; k += kLanes)
        lane_sums[c][axis] += load(weight + k) * load(column + k);
    }
  }
}

Chunk chunk_from(double* columns, const PointBlock& points, int k) {
  return {columns, points.count - k < kChunk ? points.count - k : kChunk};
}

void whitened_sums(const PointModel& model, const PointBlock& points, double* columns, PointSums& out) {
  for (int k = 0; k < points.count; k += kChunk) {
    const Chunk chunk = chunk_from(columns, points, k);
    linearise<Whitening>(model, points, k, chunk);
    add_translations(model, points, k, chunk);
    add_gram(chunk, kFixedColumns + model.column_count + kTranslations, out);
  }
}

void weighted_sums(const PointModel& model, const PointBlock& points, double* columns, PointSums& out) {
  const int count = kFixedColumns + model.column_count;
  Vec lane_sums[kMostColumns][3];
  for (int c = 0; c < count; ++c)
    for (Vec& axis : lane_sums[c]) axis = Vec{};
  Vec weight{};
  for (int k = 0; k < points.count; k += kChunk) {
    const Chunk chunk = chunk_from(columns, points, k);
    linearise<Weight>(model, points, k, chunk);
    sum_columns(chunk, points.weight + k, count, lane_sums);
    for (int at = 0; at < chunk.points; at += kLanes) {
      const Vec w = load(points.weight + k + at);
      weight += w * w;
    }
    add_gram(chunk, count, out);
  }
  for (int c = 0; c < count; ++c)
    for (int axis = 0; axis < 3; ++axis) out.sum[3 * c + axis] += sum(lane_sums[c][axis]);
  out.weight += sum(weight);
}

}  // namespace

void point_columns(const PointModel& model, const PointBlock& points, int first, double* columns) {
  linearise<Weight>(model, points, first, chunk_from(columns, points, first));
}

void point_sums(const PointModel& model, const PointBlock& points, double* columns, PointSums& out) {
  if (points.whitening[0] != nullptr) {
    whitened_sums(model, points, columns, out);
  } else {
    weighted_sums(model, points, columns, out);
  }
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
