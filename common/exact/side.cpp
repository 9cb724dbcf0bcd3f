#include "common/exact/side.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "common/exact/approx.hpp"
#include "common/exact/number_types.hpp"

namespace fracture::exact {
namespace {

// With site i as origin, u_j = j - i, and weights w, "x is closer to i than to j" means
//     0 < c_j - 2 u_j·x,    c_j = u_j·u_j + w_i - w_j.
// A polynomial P that is linear in the c's has a value and a coefficient for each c. The coefficient of w_j
// is minus that of c_j, and the coefficient of w_i is the sum of all. WeightTerm contains a site and the
// coefficient of its weight.
template <class T>
struct WeightTerm {
  const Vec3d* site;
  T coefficient;
};

template <class T, std::size_t N>
int tie_sign(std::array<WeightTerm<T>, N> terms) {
  std::sort(terms.begin(), terms.end(), [](const WeightTerm<T>& a, const WeightTerm<T>& b) {
    return lexicographic_less(*a.site, *b.site);
  });
  for (const WeightTerm<T>& t : terms)
    if (const int s = sign_of(t.coefficient)) return s;
  return 0;
}

Point<Approx> difference(const Vec3d& a, const Vec3d& b) {
  return {Approx(a.x) - Approx(b.x), Approx(a.y) - Approx(b.y), Approx(a.z) - Approx(b.z)};
}

template <class Body>
int with_integers(const BinaryScale& scale, int degree, const Body& body) {
  // 2 more bits for each difference, and 8 for the sums of products.
  if (degree * (scale.width() + 2) + 8 < 1000) return body.template operator()<FixedInt>();
  return body.template operator()<BigInt>();
}

// ---- side2. x = a + t e, e = b - a, with c_k - 2 u_k·x = 0, so t = (c_k - 2 u_k·a) / (2 u_k·e). Multiplying
// c_j - 2 u_j·x by D = u_k·e:
//     P = (c_j - 2 u_j·a) D - (u_j·e)(c_k - 2 u_k·a),   side = sign(P) sign(D).
// Coefficients: c_j: D, c_k: -(u_j·e). D is not zero, because a and b are on different sides of bisector(i,
// k).
template <class T>
struct Side2 {
  T value, d, uje;
  Side2(const Point<T>& uj, const Point<T>& uk, const Point<T>& a, const Point<T>& e) {
    d = dot(uk, e);
    uje = dot(uj, e);
    const T cj = dot(uj, uj), ck = dot(uk, uk), ja = dot(uj, a), ka = dot(uk, a);
    value = (cj - (ja + ja)) * d - uje * (ck - (ka + ka));
  }
};

// ---- side3. n = (b - a) x (c - a). By Cramer's rule, with Δ = n·(u_k x u_l),
//     x = [ (n·a)(u_k x u_l) + (c_k/2)(u_l x n) + (c_l/2)(n x u_k) ] / Δ, and so
//     P = c_j Δ - 2 (n·a) u_j·(u_k x u_l) - c_k u_j·(u_l x n) - c_l u_j·(n x u_k),   side = sign(P) sign(Δ).
template <class T>
struct Side3 {
  T value, delta, kk, kl;  // kk, kl: coefficients of c_k and c_l
  Side3(const Point<T>& uj, const Point<T>& uk, const Point<T>& ul, const Point<T>& a, const Point<T>& n) {
    const Point<T> kxl = cross(uk, ul);
    delta = dot(n, kxl);
    kk = T(0) - dot(uj, cross(ul, n));
    kl = T(0) - dot(uj, cross(n, uk));
    const T na = dot(n, a) * dot(uj, kxl);
    value = dot(uj, uj) * delta - (na + na) + dot(uk, uk) * kk + dot(ul, ul) * kl;
  }
};

// ---- order_on_edge. Let x_1 be the point of the line on plane 1 (as in side3, with u_j, u_k), d = u_j x u_k,
// and s the parameters along d. Then n_2·x_1 - n_2·a_2 = (n_2·d)(s_1 - s_2). Multiplied by 2Δ_1, with Δ_m = n_m·d:
//     P = 2 (n_1·a_1) Δ_2 + c_j n_2·(u_k x n_1) + c_k n_2·(n_1 x u_j) - 2 (n_2·a_2) Δ_1,
//     sign(s_1 - s_2) = sign(P) sign(Δ_1) sign(Δ_2).
// Both weight coefficients vanish only if n_1 x n_2 is parallel to d, which is impossible because d crosses
// both planes, or if it is zero. Then the planes are parallel, and P = 0 means that they are the same.
template <class T>
struct OrderOnEdge {
  T value, delta1, delta2, kj, kk;
  OrderOnEdge(const Point<T>& uj, const Point<T>& uk, const Point<T>& a1, const Point<T>& n1,
              const Point<T>& a2, const Point<T>& n2) {
    const Point<T> d = cross(uj, uk);
    delta1 = dot(n1, d);
    delta2 = dot(n2, d);
    kj = dot(n2, cross(uk, n1));
    kk = dot(n2, cross(n1, uj));
    const T p = dot(n1, a1) * delta2 - dot(n2, a2) * delta1;
    value = p + p + dot(uj, uj) * kj + dot(uk, uk) * kk;
  }
};

}  // namespace

int side1(const Vec3d& i, const Vec3d& j, const Vec3d& q) {
  {
    const Point<Approx> u = difference(j, i), x = difference(q, i);
    const Approx ux = dot(u, x);
    if (const int s = (dot(u, u) - (ux + ux)).certified_sign()) return s;
  }
  BinaryScale scale;
  for (const Vec3d* p : {&i, &j, &q}) scale.include(*p);
  return with_integers(scale, 2, [&]<class Int>() {
    const Point<Int> o = scale.scaled<Int>(i), u = scale.scaled<Int>(j) - o, x = scale.scaled<Int>(q) - o;
    const Int ux = dot(u, x);
    if (const int s = sign_of(Int(dot(u, u) - (ux + ux)))) return s;
    return lexicographic_less(i, j) ? 1 : -1;
  });
}

int side2(const Vec3d& i, const Vec3d& j, const Vec3d& a, const Vec3d& b, const Vec3d& k) {
  {
    const Side2<Approx> p(difference(j, i), difference(k, i), difference(a, i), difference(b, a));
    if (const int s = p.value.certified_sign() * p.d.certified_sign()) return s;
  }
  BinaryScale scale;
  for (const Vec3d* p : {&i, &j, &a, &b, &k}) scale.include(*p);
  return with_integers(scale, 5, [&]<class Int>() {
    const Point<Int> o = scale.scaled<Int>(i), sa = scale.scaled<Int>(a);
    const Side2<Int> p(scale.scaled<Int>(j) - o, scale.scaled<Int>(k) - o, sa - o, scale.scaled<Int>(b) - sa);
    const int d = sign_of(p.d);
    if (const int s = sign_of(p.value)) return s * d;
    return d * tie_sign<Int, 3>({{{&i, p.d - p.uje}, {&j, -p.d}, {&k, p.uje}}});
  });
}

int side3(const Vec3d& i, const Vec3d& j, const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& k,
          const Vec3d& l) {
  {
    const Point<Approx> n = cross(difference(b, a), difference(c, a));
    const Side3<Approx> p(difference(j, i), difference(k, i), difference(l, i), difference(a, i), n);
    if (const int s = p.value.certified_sign() * p.delta.certified_sign()) return s;
  }
  BinaryScale scale;
  for (const Vec3d* p : {&i, &j, &a, &b, &c, &k, &l}) scale.include(*p);
  return with_integers(scale, 7, [&]<class Int>() {
    const Point<Int> o = scale.scaled<Int>(i), sa = scale.scaled<Int>(a);
    const Point<Int> n = cross(scale.scaled<Int>(b) - sa, scale.scaled<Int>(c) - sa);
    const Side3<Int> p(scale.scaled<Int>(j) - o, scale.scaled<Int>(k) - o, scale.scaled<Int>(l) - o, sa - o,
                       n);
    const int d = sign_of(p.delta);
    if (const int s = sign_of(p.value)) return s * d;
    const Int wi = p.delta + p.kk + p.kl;
    return d * tie_sign<Int, 4>({{{&i, wi}, {&j, -p.delta}, {&k, -p.kk}, {&l, -p.kl}}});
  });
}

int side4(const Vec3d& i, const Vec3d& j, const Vec3d& k, const Vec3d& l, const Vec3d& m) {
  // x solves 2 u_k·x = c_k, 2 u_l·x = c_l, 2 u_m·x = c_m. This is side3 with a third bisector instead of the
  // plane,
  //     P = c_j Δ - c_k u_j·(u_l x u_m) - c_l u_j·(u_m x u_k) - c_m u_j·(u_k x u_l),  Δ = u_k·(u_l x u_m).
  const auto polynomial = [](const auto& uj, const auto& uk, const auto& ul, const auto& um) {
    const auto delta = dot(uk, cross(ul, um));
    const auto kk = dot(uj, cross(ul, um)), kl = dot(uj, cross(um, uk)), km = dot(uj, cross(uk, ul));
    const auto value = dot(uj, uj) * delta - dot(uk, uk) * kk - dot(ul, ul) * kl - dot(um, um) * km;
    return std::array{value, delta, kk, kl, km};
  };
  {
    const auto p = polynomial(difference(j, i), difference(k, i), difference(l, i), difference(m, i));
    if (const int s = p[0].certified_sign() * p[1].certified_sign()) return s;
  }
  BinaryScale scale;
  for (const Vec3d* p : {&i, &j, &k, &l, &m}) scale.include(*p);
  return with_integers(scale, 5, [&]<class Int>() {
    const Point<Int> o = scale.scaled<Int>(i);
    const auto p = polynomial(scale.scaled<Int>(j) - o, scale.scaled<Int>(k) - o, scale.scaled<Int>(l) - o,
                              scale.scaled<Int>(m) - o);
    const int d = sign_of(p[1]);
    if (const int s = sign_of(p[0])) return s * d;
    const Int wi = p[1] - p[2] - p[3] - p[4];
    return d * tie_sign<Int, 5>({{{&i, wi}, {&j, -p[1]}, {&k, p[2]}, {&l, p[3]}, {&m, p[4]}}});
  });
}

int crossing_sign(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& i, const Vec3d& j,
                  const Vec3d& k) {
  {
    const Point<Approx> n = cross(difference(b, a), difference(c, a));
    if (const int s = dot(n, cross(difference(j, i), difference(k, i))).certified_sign()) return s;
  }
  BinaryScale scale;
  for (const Vec3d* p : {&i, &j, &k, &a, &b, &c}) scale.include(*p);
  return with_integers(scale, 4, [&]<class Int>() {
    const Point<Int> o = scale.scaled<Int>(i), sa = scale.scaled<Int>(a);
    const Point<Int> n = cross(scale.scaled<Int>(b) - sa, scale.scaled<Int>(c) - sa);
    return sign_of(dot(n, cross(scale.scaled<Int>(j) - o, scale.scaled<Int>(k) - o)));
  });
}

int order_on_edge(const Vec3d& i, const Vec3d& j, const Vec3d& k, const Triangle& t1, const Triangle& t2) {
  {
    const Point<Approx> n1 = cross(difference(t1.b, t1.a), difference(t1.c, t1.a));
    const Point<Approx> n2 = cross(difference(t2.b, t2.a), difference(t2.c, t2.a));
    const OrderOnEdge<Approx> p(difference(j, i), difference(k, i), difference(t1.a, i), n1,
                                difference(t2.a, i), n2);
    if (const int s = p.value.certified_sign() * p.delta1.certified_sign() * p.delta2.certified_sign())
      return s;
  }
  BinaryScale scale;
  for (const Vec3d* p : {&i, &j, &k, &t1.a, &t1.b, &t1.c, &t2.a, &t2.b, &t2.c}) scale.include(*p);
  return with_integers(scale, 9, [&]<class Int>() {
    const Point<Int> o = scale.scaled<Int>(i), a1 = scale.scaled<Int>(t1.a), a2 = scale.scaled<Int>(t2.a);
    const Point<Int> n1 = cross(scale.scaled<Int>(t1.b) - a1, scale.scaled<Int>(t1.c) - a1);
    const Point<Int> n2 = cross(scale.scaled<Int>(t2.b) - a2, scale.scaled<Int>(t2.c) - a2);
    const OrderOnEdge<Int> p(scale.scaled<Int>(j) - o, scale.scaled<Int>(k) - o, a1 - o, n1, a2 - o, n2);
    const int d = sign_of(p.delta1) * sign_of(p.delta2);
    if (const int s = sign_of(p.value)) return s * d;
    return d * tie_sign<Int, 3>({{{&i, p.kj + p.kk}, {&j, -p.kj}, {&k, -p.kk}}});
  });
}

}  // namespace fracture::exact
