#include "core/kernels/table.hpp"
#include "core/kernels/vector.hpp"

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {
namespace {

/// Entries of C that are summed at a time: as many as there are registers for.
inline constexpr int kTileVectors = kLanes == 2 ? 2 : 3;
inline constexpr int kTileRows = kTileVectors * kLanes;
inline constexpr int kTileColumns = kLanes == 8 ? 8 : 4;
/// Products that are summed at a time, so that the rows of A stay in the first cache.
inline constexpr int kDepth = 128;
/// Columns of a triangle that are worked off one by one, before the others are by products.
inline constexpr int kPanel = 32;

int least(int a, int b) { return a < b ? a : b; }

/// to += factor from.
void add(double* to, const double* from, double factor, int count) {
  int i = 0;
  for (; i + kLanes <= count; i += kLanes) store(to + i, load(to + i) + factor * load(from + i));
  for (; i < count; ++i) to[i] += factor * from[i];
}

/// A tile's rows of A, padded with zeros, one behind the other.
void pack(const StridedMatrix& A, int rows, int depth, double* packed) {
  for (int r = 0; r < kTileRows; ++r) {
    const double* const from = A.entry + r * A.row;
    for (int k = 0; k < depth; ++k) packed[k * kTileRows + r] = r < rows ? from[k * A.column] : 0;
  }
}

/// Adds a tile's products to C; `tall` holds its rows of A, column by column. Columns of B beyond the last
/// stand for it.
///
/// @tparam kWide  columns that are summed
template <unsigned kWide>
void multiply_tile(const double* tall, long tall_stride, const StridedMatrix& B, int depth, double factor,
                   double* C, long stride, int rows, int columns) {
  const double* of_column[kWide];
  for (unsigned c = 0; c < kWide; ++c)
    of_column[c] = B.entry + least(static_cast<int>(c), columns - 1) * B.column;
  Vec sums[kWide * kTileVectors] = {};
  for (int k = 0; k < depth; ++k) {
    Vec left[kTileVectors];
#pragma GCC unroll 4
    for (int v = 0; v < kTileVectors; ++v) left[v] = load(tall + k * tall_stride + v * kLanes);
#pragma GCC unroll 8
    for (unsigned c = 0; c < kWide; ++c) {
      const Vec right = all(of_column[c][k * B.row]);
#pragma GCC unroll 4
      for (unsigned v = 0; v < kTileVectors; ++v) sums[c * kTileVectors + v] += left[v] * right;
    }
  }
  alignas(64) double tile[kWide * kTileRows];
#pragma GCC unroll 32
  for (unsigned i = 0; i < kWide * kTileVectors; ++i) store(tile + i * kLanes, sums[i]);
  for (int c = 0; c < columns; ++c) add(C + c * stride, tile + c * kTileRows, factor, rows);
}

StridedMatrix block(const StridedMatrix& A, int row, int column) {
  return {A.entry + row * A.row + column * A.column, A.row, A.column};
}

StridedMatrix transposed(const StridedMatrix& A) { return {A.entry, A.column, A.row}; }

/// Factorises the first columns of a symmetric matrix, and leaves the others to products with these.
/// @return the smallest squared pivot
double factorise_panel(double* A, long stride, int rows, int columns) {
  double smallest = __builtin_inf();
  for (int k = 0; k < columns; ++k) {
    double* const pivot = A + k * stride;
    const double squared = pivot[k];
    if (!(squared > 0)) return squared;
    smallest = squared < smallest ? squared : smallest;
    const double length = __builtin_sqrt(squared);
    for (int i = k; i < rows; ++i) pivot[i] /= length;
    for (int j = k + 1; j < columns; ++j) add(A + j * stride + j, pivot + j, -pivot[j], rows - j);
  }
  return smallest;
}

/// Triangles up to this size are solved column by column, larger ones by halves.
inline constexpr int kLeaf = 8;

int upper_half(int n) { return (n / 2 + kLeaf - 1) / kLeaf * kLeaf; }

void solve_column(const double* L, long stride, int n, double* x) {
  for (int c = 0; c < n; ++c) {
    const double* const column = L + c * stride;
    x[c] /= column[c];
    for (int i = c + 1; i < n; ++i) x[i] -= column[i] * x[c];
  }
}

void solve_column_transposed(const double* L, long stride, int n, double* x) {
  for (int c = n; c-- > 0;) {
    const double* const column = L + c * stride;
    for (int i = c + 1; i < n; ++i) x[c] -= column[i] * x[i];
    x[c] /= column[c];
  }
}

}  // namespace

void multiply(const StridedMatrix& A, const StridedMatrix& B, double factor, double* C, long stride, int rows,
              int depth, int columns, bool lower) {
  alignas(64) double packed[kTileRows * kDepth];
  for (int k = 0; k < depth; k += kDepth) {
    const int deep = least(kDepth, depth - k);
    for (int i = 0; i < rows; i += kTileRows) {
      const int high = least(kTileRows, rows - i);
      const StridedMatrix part = block(A, i, k);
      const bool stands_so = A.row == 1 && high == kTileRows;
      if (!stands_so) pack(part, high, deep, packed);
      const int end = lower ? least(columns, i + high) : columns;
      for (int j = 0; j < end; j += kTileColumns) {
        const int wide = least(kTileColumns, columns - j);
        const auto add_tile = wide == 1 ? multiply_tile<1> : multiply_tile<kTileColumns>;
        add_tile(stands_so ? part.entry : packed, stands_so ? A.column : kTileRows, block(B, k, j), deep,
                 factor, C + j * stride + i, stride, high, wide);
      }
    }
  }
}

double factorise(double* A, long stride, int n) {
  double smallest = __builtin_inf();
  for (int k = 0; k < n; k += kPanel) {
    double* const diagonal = A + k * stride + k;
    const int wide = least(kPanel, n - k), rest = n - k - wide;
    const double squared = factorise_panel(diagonal, stride, n - k, wide);
    if (!(squared > 0)) return squared;
    smallest = squared < smallest ? squared : smallest;
    const StridedMatrix below{diagonal + wide, 1, stride};
    multiply(below, transposed(below), -1, diagonal + wide * stride + wide, stride, rest, wide, rest, true);
  }
  return smallest;
}

void solve_lower(const double* L, long stride, int n, double* B, long b_stride, int columns, bool lower) {
  if (n <= kLeaf) {
    for (int j = 0; j < columns; ++j) solve_column(L, stride, n, B + j * b_stride);
    return;
  }
  const int half = upper_half(n), rest = n - half, first = lower ? least(columns, half) : columns;
  const double* const below = L + half;
  const double* const last = L + half * stride + half;
  solve_lower(L, stride, half, B, b_stride, first, lower);
  multiply({below, 1, stride}, {B, 1, b_stride}, -1, B + half, b_stride, rest, half, first, false);
  solve_lower(last, stride, rest, B + half, b_stride, first, false);
  solve_lower(last, stride, rest, B + first * b_stride + half, b_stride, columns - first, true);
}

void solve_lower_transposed(const double* L, long stride, int n, double* B, long b_stride, int columns) {
  if (n <= kLeaf) {
    for (int j = 0; j < columns; ++j) solve_column_transposed(L, stride, n, B + j * b_stride);
    return;
  }
  const int half = upper_half(n), rest = n - half;
  solve_lower_transposed(L + half * stride + half, stride, rest, B + half, b_stride, columns);
  multiply({L + half, stride, 1}, {B + half, 1, b_stride}, -1, B, b_stride, half, rest, columns, false);
  solve_lower_transposed(L, stride, half, B, b_stride, columns);
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
