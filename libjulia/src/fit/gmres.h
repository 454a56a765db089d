// SPDX-License-Identifier: Apache-2.0
/// @file gmres.h
/// Eigen's generalised minimal residual method [Saad & Schultz, SIAM J. Sci. Stat. Comput. 7(3), 1986], without
/// restarts, for a matrix that is given as a function.
#pragma once

#include <Eigen/Core>
#include <unsupported/Eigen/IterativeSolvers>

#include <algorithm>

namespace julia {

template <class Apply>
class LinearOperator;

}  // namespace julia

// The traits and types that Eigen requires of a matrix-free operator.
namespace Eigen::internal {

template <class Apply>
struct traits<julia::LinearOperator<Apply>> : traits<SparseMatrix<double>> {};

template <class Apply, class Rhs>
struct generic_product_impl<julia::LinearOperator<Apply>, Rhs, SparseShape, DenseShape, GemvProduct>
    : generic_product_impl_base<julia::LinearOperator<Apply>, Rhs,
                                generic_product_impl<julia::LinearOperator<Apply>, Rhs>> {
  template <class Dest>
  static void scaleAndAddTo(Dest& to, const julia::LinearOperator<Apply>& matrix, const Rhs& x, const double& scale) {
    VectorXd product(x.size());
    matrix.apply(x, product);
    to += scale * product;
  }
};

}  // namespace Eigen::internal

namespace julia {

/// A square matrix A, given by apply(v, Av).
template <class Apply>
class LinearOperator : public Eigen::EigenBase<LinearOperator<Apply>> {
 public:
  using Scalar = double;
  using RealScalar = double;
  using StorageIndex = int;
  enum { ColsAtCompileTime = Eigen::Dynamic, MaxColsAtCompileTime = Eigen::Dynamic, IsRowMajor = false };

  LinearOperator(const Apply& applied, Eigen::Index size) : apply(applied), mSize(size) {}
  Eigen::Index rows() const { return mSize; }
  Eigen::Index cols() const { return mSize; }
  template <class Rhs>
  Eigen::Product<LinearOperator, Rhs, Eigen::AliasFreeProduct> operator*(const Eigen::MatrixBase<Rhs>& x) const {
    return {*this, x.derived()};
  }

  const Apply& apply;

 private:
  Eigen::Index mSize;
};

struct GmresResult {
  Eigen::VectorXd x;
  int iterations = 0;
};

/// Solves A x = b until |A x - b| <= tolerance |b| by the method's own estimate, or for @a maxIterations; it stores a
/// vector for each iteration.
/// @param apply          apply(v, Av) for vectors of b's size
/// @param b              the right-hand side
/// @param tolerance      bound of the relative residual
/// @param maxIterations  1 or more
template <class Apply>
GmresResult gmres(const Apply& apply, const Eigen::VectorXd& b, double tolerance, int maxIterations) {
  const LinearOperator<Apply> matrix(apply, b.size());
  Eigen::GMRES<LinearOperator<Apply>, Eigen::IdentityPreconditioner> solver(matrix);
  solver.set_restart(std::min<Eigen::Index>(maxIterations, b.size()));
  solver.setMaxIterations(maxIterations);
  solver.setTolerance(tolerance);
  GmresResult result;
  result.x = solver.solve(b);
  result.iterations = static_cast<int>(solver.iterations());
  return result;
}

}  // namespace julia
