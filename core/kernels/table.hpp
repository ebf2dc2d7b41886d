#pragma once

#include "core/kernels/kernels.hpp"

// What the sources that are compiled for every instruction set define, and dispatch.cpp chooses from.
#define TRUEPOSE_KERNELS_OF(ISA)                                                                             \
  namespace truepose::kernels::ISA {                                                                         \
  void sincos_array(const double* angle, double* sine, double* cosine, int count);                           \
  void forward(const Arm& arm, const double* q, double* pose);                                               \
  void forward_batch(const Arm& arm, const double* q, long q_stride, double* pose, long pose_stride,         \
                     int count);                                                                             \
  void forward_jacobian(const Arm& arm, const double* q, double* pose, double* jacobian);                    \
  InverseOutcome inverse(const Arm& arm, const double* target, const InverseSettings& settings, double* q);  \
  void point_sums(const PointModel& model, const PointBlock& points, double* columns, PointSums& sums);      \
  void point_columns(const PointModel& model, const PointBlock& points, int first, double* columns);         \
  double solve_positive(double* A, int stride, int n, double* x);                                            \
  void triangulate(double* A, long stride, int rows, int columns, double* room, int* order);                 \
  void multiply(const StridedMatrix& A, const StridedMatrix& B, double factor, double* C, long stride,       \
                int rows, int depth, int columns, bool lower);                                               \
  double factorise(double* A, long stride, int n);                                                           \
  void solve_lower(const double* L, long stride, int n, double* B, long b_stride, int columns, bool lower);  \
  void solve_lower_transposed(const double* L, long stride, int n, double* B, long b_stride, int columns);   \
  void congruences(const double* rows, int blocks, int columns, const double* M, double* S);                 \
  void add_squares(const double* rows, int blocks, int columns, const double* U, double factor, double* V);  \
  void add_products(const double* rows, int blocks, int columns, const double* UP, double factor, double* V, \
                    double* W);                                                                              \
  void volume_gains(const double* V, int blocks, double* gain);                                              \
  void variance_gains(const double* V, const double* W, int blocks, double* gain);                           \
  inline constexpr Kernels                                                                                   \
      kKernels{sincos_array, forward,       forward_batch,          forward_jacobian, inverse,               \
               point_sums,   point_columns, solve_positive,         triangulate,      multiply,              \
               factorise,    solve_lower,   solve_lower_transposed, congruences,      add_squares,           \
               add_products, volume_gains,  variance_gains};                                                 \
  }
