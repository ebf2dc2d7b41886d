#include "core/kernels/table.hpp"
#include "core/kernels/vector.hpp"

namespace truepose::kernels::TRUEPOSE_KERNEL_ISA {

double solve_positive(double* A, int stride, int n, double* x) {
  double smallest = __builtin_inf();
  for (int k = 0; k < n; ++k) {
    double* const pivot = A + k * stride;
    const double squared = pivot[k];
    if (!(squared > 0)) return squared;
    smallest = squared < smallest ? squared : smallest;
    const double inverse = 1 / __builtin_sqrt(squared);
    const int begin = k / kLanes * kLanes;
    for (int i = begin; i <= n; i += kLanes) store(pivot + i, load(pivot + i) * inverse);
    for (int j = k + 1; j < n; ++j) {
      double* const column = A + j * stride;
      const double factor = pivot[j];
      for (int i = j / kLanes * kLanes; i <= n; i += kLanes)
        store(column + i, load(column + i) - factor * load(pivot + i));
    }
  }
  // The right-hand side went along as the last row: only L' x = y is left.
  for (int k = n - 1; k >= 0; --k) {
    const double* const column = A + k * stride;
    double value = column[n];
    for (int i = k + 1; i < n; ++i) value -= column[i] * x[i];
    x[k] = value / column[k];
  }
  return smallest;
}

}  // namespace truepose::kernels::TRUEPOSE_KERNEL_ISA
