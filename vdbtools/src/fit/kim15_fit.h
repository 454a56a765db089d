// SPDX-License-Identifier: Apache-2.0
/// @file kim15_fit.h
/// The method of [Kim15]: electrostatics on the surface, monopoles, and passes that minimise the shape energy.
#pragma once

#include "fit/fit_report.h"

#include "julia/fit/monopoles.h"

namespace vdbtools::fit {

/// The charge on a surface whose potential is 1 there and 0 at infinity. @throw Interrupted
julia::SurfaceCharge surfaceCharge(const julia::TriangleSurface& surface, Monitor& monitor);

/// The monopoles of the target's electrostatic potential ([Kim15] 4.4).
/// @param most    the largest number of them
/// @param result  gets the charge and the number of monopoles
/// @throw Interrupted
julia::MonopoleFit monopolesOf(const FitTarget& target, const FitOptions& options, std::size_t most, FitResult& result,
                               Monitor& monitor);

/// All passes of the schedule ([Kim15] 4.5), beginning with the monopoles.
/// @param result  as of monopolesOf()
/// @throw Interrupted
julia::Rational runSchedule(const FitTarget& target, const FitOptions& options, Report& report, FitResult& result,
                            Monitor& monitor);

}  // namespace vdbtools::fit
