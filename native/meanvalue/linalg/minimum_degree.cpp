#include "meanvalue/linalg/minimum_degree.h"

#include <algorithm>
#include <limits>

namespace meanvalue {
namespace {

constexpr Index kBits = 64;
constexpr Index kEliminated = std::numeric_limits<Index>::max();

/// The bits set in `word`; in steps that every processor has (H. S. Warren, Hacker's Delight, 5-1).
constexpr Index count_bits(std::uint64_t word) {
    word -= (word >> 1) & 0x5555555555555555U;
    word = (word & 0x3333333333333333U) + ((word >> 2) & 0x3333333333333333U);
    word = (word + (word >> 4)) & 0x0f0f0f0f0f0f0f0fU;
    return static_cast<Index>((word * 0x0101010101010101U) >> 56);
}

constexpr std::uint64_t bit(Index vertex) {
    return std::uint64_t{1} << (vertex % kBits);
}

}  // namespace

void MinimumDegree::reset(Index inner, Index size) {
    inner_ = inner;
    words_ = (size + kBits - 1) / kBits;
    bits_.assign(static_cast<std::size_t>(inner) * words_, 0);
    clique_.resize(words_);
}

void MinimumDegree::connect(Index inner, Index vertex) {
    row(inner)[vertex / kBits] |= bit(vertex);
    if (vertex < inner_) row(vertex)[inner / kBits] |= bit(inner);
}

const std::vector<Index>& MinimumDegree::order() {
    degree_.assign(inner_, 0);
    for (Index v = 0; v < inner_; ++v) {
        for (Index k = 0; k < words_; ++k)
            degree_[v] += count_bits(row(v)[k]);
    }
    order_.clear();
    for (Index k = 0; k < inner_; ++k) {
        const auto next = static_cast<Index>(std::min_element(degree_.begin(), degree_.end()) - degree_.begin());
        order_.push_back(next);
        eliminate(next);
    }
    return order_;
}

/// Its neighbours become neighbours of each other.
void MinimumDegree::eliminate(Index vertex) {
    std::copy_n(row(vertex), words_, clique_.begin());
    degree_[vertex] = kEliminated;
    for (Index k = 0; k <= (inner_ - 1) / kBits; ++k) {
        for (std::uint64_t left = clique_[k]; left != 0; left &= left - 1) {
            const Index neighbour = kBits * k + static_cast<Index>(__builtin_ctzll(left));
            if (neighbour >= inner_) return;
            std::uint64_t* const of = row(neighbour);
            of[vertex / kBits] &= ~bit(vertex);
            Index degree = -1;  // it is in the clique itself
            for (Index word = 0; word < words_; ++word) {
                of[word] |= clique_[word];
                degree += count_bits(of[word]);
            }
            of[neighbour / kBits] &= ~bit(neighbour);
            degree_[neighbour] = degree;
        }
    }
}

}  // namespace meanvalue
