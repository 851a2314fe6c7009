#include "meanvalue/sequence/run.h"

namespace meanvalue {

void Run::finish() {
    is_done = true;
    std::vector<float*>().swap(shapes);
    std::vector<Seam::Shape>().swap(aside);
    std::vector<char>().swap(is_solved);
    shape.resize(0, 3);
    Archive::Bytes().swap(drag);
}

}  // namespace meanvalue
