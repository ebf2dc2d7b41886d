#include "core/kernels/table.hpp"
#include "core/kernels/vector.hpp"

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {
namespace {

/// Columns that are reflected at a time.
inline constexpr int kTogether = 4;

/// Reflects kColumns columns: a -= beta v v'a. Rows before `begin` are zero in v.
template <int kColumns>
void reflect(const double* v, double beta, double* columns, long stride, int begin, int rows) {
  Vec sums_of[kTogether] = {};
  for (int i = begin; i < rows; i += kLanes) {
    const Vec at = load(v + i);
#pragma GCC unroll 4
    for (int c = 0; c < kColumns; ++c) sums_of[c] += at * load(columns + c * stride + i);
  }
  Vec along[kTogether];
  for (int c = 0; c < kColumns; ++c) along[c] = all(beta * sum(sums_of[c]));
  for (int i = begin; i < rows; i += kLanes) {
    const Vec at = load(v + i);
#pragma GCC unroll 4
    for (int c = 0; c < kColumns; ++c) {
      double* const to = columns + c * stride + i;
      store(to, load(to) - along[c] * at);
    }
  }
}

/// Squared length of a column from row k on.
double squared_length(const double* column, int k, int rows) {
  const int begin = k / kLanes * kLanes;
  const Vec first = choose(lane_numbers(Lanes{}) >= all(k - begin), load(column + begin), Vec{});
  Vec squares = first * first;
  for (int i = begin + kLanes; i < rows; i += kLanes) squares += load(column + i) * load(column + i);
  return sum(squares);
}

template <typename Number>
void exchange(Number& a, Number& b) {
  const Number other = a;
  a = b;
  b = other;
}

/// Squared lengths of what is left of the columns: each finished row is subtracted, and they are summed again
/// before cancellation makes columns indistinguishable.
struct LengthsLeft {
  double *now, *summed;  ///< of each column

  void sum_up(int j, const double* column, int k, int rows) {
    now[j] = summed[j] = squared_length(column, k, rows);
  }
  /// @param k  row that is done
  void take_off(int j, const double* column, int k, int rows) {
    constexpr double kDigitsLost = 1e-3;
    now[j] -= column[k] * column[k];
    if (!(now[j] > kDigitsLost * summed[j])) sum_up(j, column, k + 1, rows);
  }
};

/// Brings the column of which most is left to place k.
void take_longest(double* A, long stride, int rows, int columns, int k, LengthsLeft& left, int* order) {
  int longest = k;
  for (int j = k + 1; j < columns; ++j)
    if (left.now[j] > left.now[longest]) longest = j;
  exchange(left.now[k], left.now[longest]);
  exchange(left.summed[k], left.summed[longest]);
  double *const here = A + k * stride, *const there = A + longest * stride;
  for (int i = 0; i < rows && longest != k; i += kLanes) {
    const Vec other = load(there + i);
    store(there + i, load(here + i));
    store(here + i, other);
  }
  exchange(order[k], order[longest]);
}

}  // namespace

void triangulate(double* A, long stride, int rows, int columns, double* room, int* order) {
  double* const v = room;
  LengthsLeft left{room + rows, room + rows + columns};
  for (int j = 0; j < columns && order != nullptr; ++j) left.sum_up(j, A + j * stride, 0, rows);
  for (int k = 0; k < columns; ++k) {
    if (order != nullptr) take_longest(A, stride, rows, columns, k, left, order);
    double* const pivot = A + k * stride;
    const int begin = k / kLanes * kLanes;
    for (int i = begin; i < rows; ++i) v[i] = i < k ? 0 : pivot[i];
    Vec squares{};
    for (int i = begin; i < rows; i += kLanes) squares += load(v + i) * load(v + i);
    const double length = __builtin_sqrt(sum(squares));
    if (!(length > 0)) continue;
    // Away from the axis, so that nothing cancels.
    const double diagonal = pivot[k] > 0 ? -length : length;
    v[k] -= diagonal;
    const double beta = 1 / (length * __builtin_fabs(v[k]));
    int j = k + 1;
    for (; j + kTogether <= columns; j += kTogether)
      reflect<kTogether>(v, beta, A + j * stride, stride, begin, rows);
    for (; j < columns; ++j) reflect<1>(v, beta, A + j * stride, stride, begin, rows);
    pivot[k] = diagonal;
    for (j = k + 1; j < columns && order != nullptr; ++j) left.take_off(j, A + j * stride, k, rows);
  }
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
