// Which of some numbered items hang together (union-find).
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "meanvalue/common/types.h"

namespace meanvalue {

class DisjointSets {
  public:
    explicit DisjointSets(Index count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

    Index root(Index item) {
        while (parent_[item] != item) {
            parent_[item] = parent_[parent_[item]];
            item = parent_[item];
        }
        return item;
    }

    /// The lower root stays root, so that a set is named by its lowest member.
    void join(Index a, Index b) {
        a = root(a);
        b = root(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<Index> parent_;
};

}  // namespace meanvalue
