#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

/// Sets and compares every member of records, so that one that a reader or writer forgot shows itself: a
/// record that gets another member no longer compiles here until its number is changed, and then fails until
/// the member is in its layout.
namespace truepose {

/// How many members a record has.
template <class T>
inline constexpr int kMembers = 0;

template <class T>
requires(kMembers<std::remove_const_t<T>> > 0) auto members(T& record) {
  constexpr int kCount = kMembers<std::remove_const_t<T>>;
  if constexpr (kCount == 1) {
    auto& [m0] = record;
    return std::tie(m0);
  } else if constexpr (kCount == 2) {
    auto& [m0, m1] = record;
    return std::tie(m0, m1);
  } else if constexpr (kCount == 3) {
    auto& [m0, m1, m2] = record;
    return std::tie(m0, m1, m2);
  } else if constexpr (kCount == 4) {
    auto& [m0, m1, m2, m3] = record;
    return std::tie(m0, m1, m2, m3);
  } else if constexpr (kCount == 5) {
    auto& [m0, m1, m2, m3, m4] = record;
    return std::tie(m0, m1, m2, m3, m4);
  } else if constexpr (kCount == 6) {
    auto& [m0, m1, m2, m3, m4, m5] = record;
    return std::tie(m0, m1, m2, m3, m4, m5);
  } else if constexpr (kCount == 7) {
    auto& [m0, m1, m2, m3, m4, m5, m6] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6);
  } else if constexpr (kCount == 8) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7);
  } else if constexpr (kCount == 9) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8);
  } else if constexpr (kCount == 10) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8, m9);
  } else if constexpr (kCount == 11) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10);
  } else if constexpr (kCount == 12) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11);
  } else if constexpr (kCount == 13) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12);
  } else if constexpr (kCount == 14) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13);
  } else if constexpr (kCount == 15) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14);
  } else if constexpr (kCount == 16) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15);
  } else if constexpr (kCount == 18) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17);
  } else if constexpr (kCount == 20) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17, m18, m19] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17, m18, m19);
  } else if constexpr (kCount == 23) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17, m18, m19, m20, m21,
           m22] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17, m18, m19,
                    m20, m21, m22);
  } else if constexpr (kCount == 47) {
    auto& [m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17, m18, m19, m20, m21,
           m22, m23, m24, m25, m26, m27, m28, m29, m30, m31, m32, m33, m34, m35, m36, m37, m38, m39, m40, m41,
           m42, m43, m44, m45, m46] = record;
    return std::tie(m0, m1, m2, m3, m4, m5, m6, m7, m8, m9, m10, m11, m12, m13, m14, m15, m16, m17, m18, m19,
                    m20, m21, m22, m23, m24, m25, m26, m27, m28, m29, m30, m31, m32, m33, m34, m35, m36, m37,
                    m38, m39, m40, m41, m42, m43, m44, m45, m46);
  }
}

/// Gives every member a value of its own: whole numbers as they count, numbers in quarters between 0 and 1.
class Filler {
 public:
  template <class T>
  void operator()(T& x) {
    if constexpr (kMembers < T >> 0) {
      std::apply([this](auto&... member) { ((*this)(member), ...); }, members(x));
    } else if constexpr (std::is_same_v<T, bool>) {
      x = true;
    } else if constexpr (std::is_enum_v<T>) {
      x = static_cast<T>(1);
    } else if constexpr (std::is_same_v<T, std::int8_t>) {
      x = ++count_ % 2 ? 1 : -1;
    } else if constexpr (std::is_integral_v<T>) {
      x = static_cast<T>(++count_);
    } else if constexpr (std::is_floating_point_v<T>) {
      x = ++count_ / 1024.0;
    } else if constexpr (std::is_same_v<T, std::string>) {
      x = "text \"" + std::to_string(++count_) + "\"";
    } else if constexpr (std::is_same_v<T, Eigen::Isometry3d>) {
      x = Eigen::Translation3d(++count_, 2, 3) *
          Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized());
    } else if constexpr (requires { x.emplace_back(); }) {
      (*this)(x.emplace_back());
      (*this)(x.emplace_back());
    } else if constexpr (requires { x.emplace(); }) {
      (*this)(x.emplace());
    } else if constexpr (requires { x.first; }) {
      (*this)(x.first);
      (*this)(x.second);
    } else if constexpr (requires { x.coeffs(); } || std::is_base_of_v<Eigen::EigenBase<T>, T>) {
      if constexpr (T::SizeAtCompileTime == Eigen::Dynamic) x.resize(2, 1);
      for (Eigen::Index i = 0; i < x.size(); ++i) (*this)(x(i));
    }
  }

 private:
  int count_ = 0;
};

/// Whether all members are the same, numbers to the rounding of a unit.
template <class T>
bool same(const T& a, const T& b) {
  if constexpr (kMembers < T >> 0) {
    return std::apply(
        [&b](const auto&... of_a) {
          return std::apply([&](const auto&... of_b) { return (same(of_a, of_b) && ...); }, members(b));
        },
        members(a));
  } else if constexpr (std::is_floating_point_v<T>) {
    return std::abs(a - b) <= 1e-12 * (1 + std::abs(a));
  } else if constexpr (std::is_same_v<T, Eigen::Isometry3d>) {
    return a.isApprox(b, 1e-12);
  } else if constexpr (std::is_base_of_v<Eigen::EigenBase<T>, T>) {
    return a.rows() == b.rows() && a.cols() == b.cols() && a.isApprox(b, 1e-12);
  } else if constexpr (requires { a.has_value(); }) {
    return a.has_value() == b.has_value() && (!a || same(*a, *b));
  } else if constexpr (requires { a.first; }) {
    return same(a.first, b.first) && same(a.second, b.second);
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    return a == b;
  } else if constexpr (requires { a.push_back(a.front()); } ||
                       (requires { a.begin(); } && !std::is_same_v<T, std::string>)) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const auto& x, const auto& y) { return same(x, y); });
  } else {
    return a == b;
  }
}

}  // namespace truepose
