// Programs made by chance, of eight kinds: what a part program can contain, over five decades of length.
#pragma once

#include <vector>

#include "motion/kernel.hpp"

namespace headstock::motion::rig {

/// Kinds by seed % 8: lines of one scale · of all scales · many short, few long · lines and arcs · a wave of
/// 0.1 mm segments · a wandering CAM path · gentle and sharp turns · arcs in arcs, tangent. Tolerance 0.01,
/// 0.003 or 0.05 mm.
std::vector<Move> random_program(unsigned seed, std::size_t count);

AxisVector end_of(const Move& move);

}  // namespace headstock::motion::rig
