#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/math/dense_algebra.hpp"
#include "core/math/random.hpp"
#include "core/step_count.hpp"
#include "tools/experiment/point_cloud.hpp"
#include "tools/experiment/regression_methods.hpp"

namespace truepose {
namespace {

// The cost of training grows with the cube of the weights: as many hidden units as stay within so many.
constexpr Eigen::Index kMostWeights = 220, kFewestHidden = 4, kMostHidden = 12;
constexpr int kMembers = 3;
constexpr int kMaxIterations = 35;

/// Sizes of a network, and its weights seen as two matrices.
struct Shape {
  Eigen::Index inputs, hidden, outputs;

  Eigen::Index first() const { return hidden * (inputs + 1); }
  Eigen::Index weights() const { return first() + outputs * (hidden + 1); }
  auto W1(const double* w) const { return Eigen::Map<const Eigen::MatrixXd>{w, hidden, inputs + 1}; }
  auto W2(const double* w) const {
    return Eigen::Map<const Eigen::MatrixXd>{w + first(), outputs, hidden + 1};
  }
};

struct Precisions {
  double decay = 1e-2;  ///< of the weights
  double noise = 1;     ///< of the targets
};

/// One network in training: least squares of its errors, with weight decay.
class Training {
 public:
  Training(const Shape& shape, const Eigen::MatrixXd& Z, const Eigen::MatrixXd& T, std::uint64_t seed)
      : shape_{shape}, Z_{Z}, T_{T}, w_(shape.weights()) {
    Random random{seed};
    const double spread = 1 / std::sqrt(static_cast<double>(shape.inputs));
    for (double& w : w_) w = spread * random.normal();
  }

  /// Levenberg-Marquardt until a step gains little. With `adapt`, the precisions follow the evidence.
  void run(Precisions& precisions, bool adapt) {
    double damping = 1e-2;
    for (int i = 0; i < kMaxIterations && damping < 1e10; ++i) {
      count_step();
      linearise();
      const double before = cost(w_, precisions);
      const double gain = before - step(precisions, before, damping);
      if (adapt) follow_evidence(precisions);
      if (gain < 1e-5 * before) break;
    }
  }

  const Eigen::VectorXd& weights() const { return w_; }

 private:
  Eigen::MatrixXd hidden(const Eigen::VectorXd& w) const {
    const auto W1 = shape_.W1(w.data());
    return (times_transposed(Z_, W1.leftCols(shape_.inputs)).rowwise() + W1.col(shape_.inputs).transpose())
        .array()
        .tanh();
  }
  Eigen::MatrixXd errors(const Eigen::MatrixXd& A, const Eigen::VectorXd& w) const {
    const auto W2 = shape_.W2(w.data());
    return (times_transposed(A, W2.leftCols(shape_.hidden)).rowwise() + W2.col(shape_.hidden).transpose()) -
           T_;
  }
  double cost(const Eigen::VectorXd& w, const Precisions& p) const {
    return 0.5 * (p.noise * errors(hidden(w), w).squaredNorm() + p.decay * w.squaredNorm());
  }

  /// J'J and J'e. Between a target and the weights before the hidden layer stand only the weights behind it,
  /// so one product over the points serves all targets.
  void linearise() {
    const Eigen::MatrixXd A = hidden(w_), E = errors(A, w_);
    const Eigen::Index H = shape_.hidden, first = shape_.first(), m = shape_.outputs;
    const auto W2 = shape_.W2(w_.data()).leftCols(H);
    const Eigen::MatrixXd slopes = 1 - A.array().square();
    Eigen::MatrixXd G(Z_.rows(), first);  // derivatives of the hidden layer to the weights before it
    for (Eigen::Index k = 0; k < shape_.inputs; ++k) G.middleCols(k * H, H) = Z_.col(k).asDiagonal() * slopes;
    G.rightCols(H) = slopes;
    Eigen::MatrixXd B(Z_.rows(), H + 1);  // derivatives of a target to the weights behind it
    B << A, Eigen::VectorXd::Ones(Z_.rows());

    const Eigen::MatrixXd GtG = gram(G), W2tW2 = gram(W2);
    const Eigen::MatrixXd BtG = transposed_times(B, G), BtB = gram(B);
    JtJ_ = Eigen::MatrixXd::Zero(w_.size(), w_.size());
    JtJ_.topLeftCorner(first, first) =
        GtG.cwiseProduct(W2tW2.replicate(shape_.inputs + 1, shape_.inputs + 1));
    for (Eigen::Index o = 0; o < m; ++o) {
      const auto weights = Eigen::seqN(first + o, H + 1, m);
      const Eigen::RowVectorXd onward = W2.row(o).replicate(1, shape_.inputs + 1);
      JtJ_(weights, Eigen::seqN(0, first)) = BtG * onward.asDiagonal();
      JtJ_(weights, weights) = BtB;
    }
    const Eigen::MatrixXd back = times(E, W2);  // errors, as the hidden layer sees them
    Jte_.resize(w_.size());
    for (Eigen::Index k = 0; k <= shape_.inputs; ++k)
      Jte_.segment(k * H, H) = G.middleCols(k * H, H).cwiseProduct(back).colwise().sum().transpose();
    Jte_.tail(m * (H + 1)) = transposed_times(E, B).reshaped();
    squared_error_ = E.squaredNorm();
  }

  /// Takes a step that lowers the cost, damping it as much as needed; the cost then.
  double step(const Precisions& p, double before, double& damping) {
    for (; damping < 1e10; damping *= 10) {
      Eigen::MatrixXd H = p.noise * JtJ_;
      H.diagonal().array() += p.decay + damping;
      const Eigen::VectorXd trial = w_ - CholeskyFactor(std::move(H)).solve(p.noise * Jte_ + p.decay * w_);
      const double after = cost(trial, p);
      if (!(after < before)) continue;
      w_ = trial;
      damping = std::max(1e-8, damping / 10);
      return after;
    }
    return before;
  }

  /// Decay and noise that maximise the evidence, given how many weights the data determine.
  void follow_evidence(Precisions& p) const {
    Eigen::MatrixXd H = p.noise * JtJ_;
    H.diagonal().array() += p.decay;
    const double trace = CholeskyFactor(std::move(H)).inverse_lower().squaredNorm();  // of H^-1
    const auto P = static_cast<double>(w_.size());
    const double known = std::clamp(P - p.decay * trace, 1e-3, P);
    const double residuals = static_cast<double>(T_.size());
    p.decay = std::clamp(known / w_.squaredNorm(), 1e-4, 1e4);
    p.noise = std::clamp((residuals - std::min(known, 0.9 * residuals)) / squared_error_, 1e-2, 1e8);
  }

  Shape shape_;
  const Eigen::MatrixXd &Z_, &T_;
  Eigen::VectorXd w_;
  Eigen::MatrixXd JtJ_;
  Eigen::VectorXd Jte_;
  double squared_error_ = 0;
};

struct Trained {
  Shape shape;
  Hyper hyper;
  std::vector<Eigen::VectorXd> members;  ///< weights of each, column by column, biases last
};

/// Trains every member; each finds its precisions unless they are given.
Trained train(const RegressionData& data, const std::optional<Precisions>& given) {
  const Eigen::MatrixXd Z = FeatureScale{data.X}.apply_all(data.X);
  const Eigen::MatrixXd T = data.Y * target_scale(data.Y).cwiseInverse().asDiagonal();
  const auto hidden = std::clamp(kMostWeights / (Z.cols() + 1 + T.cols()), kFewestHidden, kMostHidden);
  Trained trained{.shape = {Z.cols(), hidden, T.cols()}, .hyper = {}, .members = {}};
  double log_decay = 0, log_noise = 0;
  for (int member = 0; member < kMembers; ++member) {
    Precisions precisions = given.value_or(Precisions{});
    Training training{trained.shape, Z, T, static_cast<std::uint64_t>(member)};
    training.run(precisions, !given);
    trained.members.push_back(training.weights());
    log_decay += std::log(precisions.decay) / kMembers;
    log_noise += std::log(precisions.noise) / kMembers;
  }
  trained.hyper = {{"decay", given ? given->decay : std::exp(log_decay)},
                   {"noise", given ? given->noise : std::exp(log_noise)}};
  return trained;
}

class NeuralNetwork final : public Regressor {
 public:
  NeuralNetwork(const RegressionData& data, Trained trained)
      : Regressor{{data.X, data.Y, std::move(trained.hyper)}},
        shape_{trained.shape},
        members_{std::move(trained.members)},
        cloud_{data.X},
        target_scale_{target_scale(data.Y)} {}

  void predict(const Eigen::Ref<const Eigen::VectorXd>& x,
               Eigen::Ref<Eigen::VectorXd> y) const noexcept override {
    const Features z = cloud_.scaled(x);
    y.setZero();
    for (const Eigen::VectorXd& w : members_) {
      const auto W1 = shape_.W1(w.data());
      const auto W2 = shape_.W2(w.data());
      y += W2.col(shape_.hidden);
      for (Eigen::Index h = 0; h < shape_.hidden; ++h)
        y += std::tanh(W1.row(h).head(shape_.inputs).dot(z) + W1(h, shape_.inputs)) * W2.col(h);
    }
    const double belief = cloud_.belief(cloud_.nearest(z, 1).span().front().distance);
    y = (belief / kMembers * y.array() * target_scale_.array()).matrix();
  }

 private:
  Shape shape_;
  std::vector<Eigen::VectorXd> members_;
  PointCloud cloud_;
  Eigen::VectorXd target_scale_;
};

}  // namespace

const RegressionMethod kNeuralNetwork{
    .name = "nn",
    .fit = [](const RegressionData& data, int /*jobs*/) -> RegressorPtr {
      return std::make_shared<NeuralNetwork>(data, train(data, std::nullopt));
    },
    .refit = [](const Hyper& hyper, const RegressionData& data) -> RegressorPtr {
      return std::make_shared<NeuralNetwork>(data,
                                             train(data, Precisions{hyper.at("decay"), hyper.at("noise")}));
    }};

}  // namespace truepose
