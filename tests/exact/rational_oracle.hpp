// The oracle of the predicate tests: the definitions, evaluated in rational arithmetic and written without
// looking at the code under test. It applies the tie rule literally. Every site gets a weight that is a power
// of an actual infinitesimal, represented by a polynomial in it. So the oracle uses no cofactors.
#pragma once

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <map>
#include <vector>

#include "common/base/vec.hpp"

namespace fracture::test {

using Rational = boost::multiprecision::cpp_rational;

inline Rational rational(double v) { return Rational(v); }

/// Determinant by expansion along the first row.
template <class T>
T determinant(const std::vector<std::vector<T>>& m) {
  if (m.size() == 1) return m[0][0];
  T sum = T(0);
  for (std::size_t k = 0; k < m.size(); ++k) {
    std::vector<std::vector<T>> rest;
    for (std::size_t r = 1; r < m.size(); ++r) {
      std::vector<T> row;
      for (std::size_t c = 0; c < m.size(); ++c)
        if (c != k) row.push_back(m[r][c]);
      rest.push_back(row);
    }
    const T term = m[0][k] * determinant(rest);
    if (k % 2 == 0)
      sum = sum + term;
    else
      sum = sum - term;
  }
  return sum;
}

/// The sign of det[b - a; c - a; d - a].
inline int orient3d_oracle(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  std::vector<std::vector<Rational>> rows;
  for (const Vec3d& p : {b, c, d})
    rows.push_back(
        {rational(p.x) - rational(a.x), rational(p.y) - rational(a.y), rational(p.z) - rational(a.z)});
  const Rational det = determinant(rows);
  return det.sign();
}

/// A real number plus infinitesimals: value + sum of c_k e_k with e_0 >> e_1 >> ... > 0. Products of
/// infinitesimals never arise below, because the weights enter the determinant in one column only.
/// Multiplication asserts this.
struct Perturbed {
  Rational value;
  std::array<Rational, 5> infinitesimal{};

  Perturbed(Rational v = 0) : value(std::move(v)) {}  // NOLINT
  friend Perturbed operator+(Perturbed a, const Perturbed& b) {
    a.value += b.value;
    for (int k = 0; k < 5; ++k) a.infinitesimal[k] += b.infinitesimal[k];
    return a;
  }
  friend Perturbed operator-(Perturbed a, const Perturbed& b) {
    a.value -= b.value;
    for (int k = 0; k < 5; ++k) a.infinitesimal[k] -= b.infinitesimal[k];
    return a;
  }
  friend Perturbed operator*(const Perturbed& a, const Perturbed& b) {
    Perturbed r(a.value * b.value);
    for (int k = 0; k < 5; ++k)
      r.infinitesimal[k] = a.value * b.infinitesimal[k] + b.value * a.infinitesimal[k];
    return r;
  }
  int sign() const {
    if (value != 0) return value.sign();
    for (const Rational& c : infinitesimal)
      if (c != 0) return c.sign();
    return 0;
  }
};

/// Whether the weighted site e is closer than orthogonal to the power sphere of the weighted sites a, b, c,
/// d. It lifts each site to |s|^2 - w_s and asks whether e lies below the hyperplane through the lifted a, b,
/// c, d. That is the definition of the regular triangulation. Returns +1 if e is in conflict and -1 if not.
/// It never returns 0 if the tie rule is complete.
inline int in_sphere_oracle(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& e) {
  const std::array<Vec3d, 5> sites{a, b, c, d, e};
  std::array<int, 5> by_weight{0, 1, 2, 3, 4};  // heaviest first: lexicographically smallest
  std::sort(by_weight.begin(), by_weight.end(), [&](int i, int j) {
    return std::array{sites[i].x, sites[i].y, sites[i].z} < std::array{sites[j].x, sites[j].y, sites[j].z};
  });
  std::vector<std::vector<Perturbed>> rows(5);
  for (int i = 0; i < 5; ++i) {
    const Rational x = rational(sites[i].x), y = rational(sites[i].y), z = rational(sites[i].z);
    Perturbed lift(x * x + y * y + z * z);
    for (int rank = 0; rank < 5; ++rank)
      if (by_weight[rank] == i) lift.infinitesimal[rank] = -1;  // the weight, with its minus sign
    rows[i] = {Perturbed(1), Perturbed(x), Perturbed(y), Perturbed(z), lift};
  }
  // For positive (a, b, c, d), this 5x5 determinant is the height of e's lift above the hyperplane times the
  // (positive) volume. By Laplace along the last row, its leading term is lift(e) * det[1 abcd], with sign +.
  return -determinant(rows).sign();
}

}  // namespace fracture::test
