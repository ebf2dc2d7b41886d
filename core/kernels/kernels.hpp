#pragma once

// Compiled for every instruction set: no header with inline functions may be included here, or the linker
// could pick the AVX-512 copy of one for a machine without.

namespace truepose::kernels {

inline constexpr int kMostJoints = 16;
/// Links of an arm that points are compared with, whose guides are links too.
inline constexpr int kMostLinks = 32;
/// Doubles of the widest vector: arrays for the kernels are padded to and aligned with so many.
inline constexpr int kMostLanes = 8;
/// One vector's worth, to allocate such arrays from.
struct alignas(64) Line {
  double value[kMostLanes];
};
/// Points whose Jacobian is held at a time, so that it stays in the first cache.
inline constexpr int kChunk = 32;

/// Instruction sets that the kernels are compiled for: x86-64 (or another machine's own), x86-64-v3 and -v4.
enum class Isa { Baseline, Avx2, Avx512 };

/// A link before its joint moves: Rot(y, beta) Rot(x, alpha) Trans(a, 0, 0) Rot(z, theta) Trans(0, 0, d).
struct Link {
  double cos_beta, sin_beta, cos_alpha, sin_alpha, a_mm;
  double theta_rad, cos_theta, sin_theta, d_mm;
};

/// A serial arm as the product L_0 Z_0(q_0) L_1 Z_1(q_1) .. L_N, with L constant and Z_i a turn about or a
/// slide along the z axis. mm, rad. Up to kMostJoints joints; kMostLinks where points are compared with it.
struct alignas(64) Arm {
  double transform[kMostLinks + 1][16];  ///< L_i, homogeneous, column by column
  Link link[kMostLinks];                 ///< the same in its parts
  double turn[kMostLinks];               ///< rad per unit of q_i, 0 for a prismatic joint
  double slide[kMostLinks];              ///< mm per unit of q_i, 0 for a revolute joint
  int joints;
  bool bare;  ///< the flange is the last joint's frame: L_N is the identity
};

struct InverseSettings {
  double position_tolerance_mm;
  double rotation_tolerance_rad;
  double length_mm;  ///< weighs 1 rad against millimetres
  int max_iterations;
  int leaps;  ///< searches by steps that need not descend, where no descent leads to the pose
};

enum class InverseStatus { Converged, DidNotConverge, NotFinite };

struct InverseOutcome {
  InverseStatus status;
  int iterations;
  double residual_mm;
  double residual_rad;
};

/// Measured points of one reflector; arrays aligned with kMostLanes.
struct PointBlock {
  const double* measured[3];  ///< tracker frame, mm
  const double* weight;       ///< 0 for padding
  /// The upper triangle, row by row, of the matrix that multiplies a point's residual in the tracker frame;
  /// null where `weight` does.
  const double* whitening[6];
  const double* basis;   ///< of deviation term t at basis + t * stride, the joint's sign included
  const double* first;   ///< of joint i at first + i * stride: cosine of the turn, or the slide (mm)
  const double* second;  ///< sine of the turn
  int stride;
  int count;  ///< a multiple of kMostLanes
};

/// Dot products are summed in blocks of up to this many rows and columns, which may overhang the last.
inline constexpr int kBlock = 4;

/// What a column of the Jacobian is the derivative to, of link `link` where it is a link's.
enum class ColumnKind { A, Alpha, D, Theta, Beta };
struct LinkColumn {
  ColumnKind kind;
  int link;
  int term = -1;  ///< of a deviation, whose basis multiplies the column; -1 = the link's own
};

/// The arm that the points are compared with, and the columns wanted.
struct PointModel {
  const Arm* arm;
  double rotation[9];   ///< R_WB, column by column
  double origin[3];     ///< of the base in the tracker frame, mm
  double reflector[3];  ///< in the flange frame, mm
  const LinkColumn* columns;
  int column_count;
};

/// Local columns that come before those of the links: the residual, three turns of the base about its own
/// axes, three coordinates of the reflector.
inline constexpr int kFixedColumns = 7;
/// Behind those of the links where points are whitened: three translations of the base along its own axes.
/// Where they are weighed the translations' products are sums of the other columns.
inline constexpr int kTranslations = 3;
inline constexpr int kMostLinkColumns = 160;
inline constexpr int kMostColumns = kFixedColumns + kMostLinkColumns + kTranslations;

/// Weighted sums over points, all vectors in the base frame.
struct PointSums {
  double* gram;  ///< dot products of the local columns, row i at gram + i * stride, those with j >= i; kBlock
                 ///< rows and columns more than those
  double* sum;   ///< of each local column, three coordinates; not where points are whitened
  double weight;  ///< sum of the squared weights; not where points are whitened
  int stride;
};

/// Entry (i, j) of a matrix at entry[i * row + j * column].
struct StridedMatrix {
  const double* entry;
  long row, column;
};

/// The kernels of one instruction set. Pointers do not alias unless said.
struct Kernels {
  /// Sine and cosine of `count` angles, within 2 ulp up to 1e5 rad and the C library's beyond.
  void (*sincos)(const double* angle, double* sine, double* cosine, int count);

  /// The flange's pose, homogeneous, column by column. mm. Here and below q has room for a multiple of
  /// kMostLanes numbers; those beyond the arm's joints are not regarded.
  void (*forward)(const Arm& arm, const double* q, double* pose);

  /// `count` poses: joint i of pose k at q[i * q_stride + k], entry j (x, y, z axis, origin) at
  /// pose[j * pose_stride + k].
  void (*forward_batch)(const Arm& arm, const double* q, long q_stride, double* pose, long pose_stride,
                        int count);

  /// Pose, and the geometric Jacobian, 6 rows a column.
  void (*forward_jacobian)(const Arm& arm, const double* q, double* pose, double* jacobian);

  /// Newton from the seed in q to the homogeneous pose `target`; q is the solution where converged.
  InverseOutcome (*inverse)(const Arm& arm, const double* target, const InverseSettings& settings, double* q);

  /// Adds the points' part to the sums. `columns` is room for the local columns of kChunk points, 3 kChunk
  /// doubles each, aligned.
  void (*point_sums)(const PointModel& model, const PointBlock& points, double* columns, PointSums& sums);

  /// The weighted local columns of the points from `first` on, kChunk of them or those that are left (a
  /// multiple of kMostLanes), as point_sums() has them: three coordinates of so many numbers each, columns
  /// 3 kChunk apart.
  void (*point_columns)(const PointModel& model, const PointBlock& points, int first, double* columns);

  /// Solves A x = b for a positive definite A (n x n, lower half used) with b' as row n below it; both are
  /// overwritten. Column by column, the stride a multiple of kMostLanes and above n, aligned.
  /// @return the smallest squared pivot; not positive where A is not positive definite, and x is not set
  double (*solve_positive)(double* A, int stride, int n, double* x);

  /// Leaves R of A = Q R in the upper triangle of A, by reflections; what is below means nothing. Column by
  /// column; `rows` a multiple of kMostLanes and no fewer than the columns, padded with zeros. `room` is
  /// for as many numbers as a column has and two for each column. `order`: the columns' numbers, permuted so
  /// that each pivot is the longest left; null: they stay in place.
  void (*triangulate)(double* A, long stride, int rows, int columns, double* room, int* order);

  // Dense matrices of any size, not aligned, those without strides column by column.

  /// C += factor A B, with `depth` columns of A. With `lower` what is above the diagonal of C means nothing.
  void (*multiply)(const StridedMatrix& A, const StridedMatrix& B, double factor, double* C, long stride,
                   int rows, int depth, int columns, bool lower);
  /// Leaves L of A = L L' in the lower triangle, which alone is read; what is above means nothing.
  /// @return the smallest squared pivot; not positive where A is not positive definite, and L means nothing
  double (*factorise)(double* A, long stride, int n);
  /// Solves L X = B in place of B. `lower`: B is lower triangular, and so is X.
  void (*solve_lower)(const double* L, long stride, int n, double* B, long b_stride, int columns, bool lower);
  /// Solves L' X = B in place of B.
  void (*solve_lower_transposed)(const double* L, long stride, int n, double* B, long b_stride, int columns);

  // Choosing poses. Candidates stand in blocks of kMostLanes, one a lane; a matrix of each candidate is kept
  // entry by entry, row by row, of a symmetric 3 x 3 one those with row <= column.

  /// S = A M A' of every candidate: A 3 x columns, M symmetric, three of its columns after the other, each
  /// three row by row and the last filled up with zeros.
  void (*congruences)(const double* rows, int blocks, int columns, const double* M, double* S);
  /// V += factor X X' with X = A U of every candidate: U columns x 3 row by row.
  void (*add_squares)(const double* rows, int blocks, int columns, const double* U, double factor, double* V);
  /// The same, and W += factor (X Y' + Y X') with Y = A P: U and P side by side, columns x 6 row by row.
  void (*add_products)(const double* rows, int blocks, int columns, const double* UP, double factor,
                       double* V, double* W);
  /// The determinant of I + V.
  void (*volume_gains)(const double* V, int blocks, double* gain);
  /// The trace of (I + V)^-1 W.
  void (*variance_gains)(const double* V, const double* W, int blocks, double* gain);
};

/// Whether this machine has the instruction set and this build the code.
bool available(Isa isa);
/// @param isa  available
const Kernels& kernels_for(Isa isa);
/// The code of the best instruction set that this machine has.
const Kernels& best();

}  // namespace truepose::kernels
