// Dawn: refuses it: cannot apply '@location' to declaration of type 'bool'
// Umbrage: a `bool` cannot go in or out of a stage: numbers and vectors of them alone can
@fragment fn fs() -> @location(0) bool {
    return true;
}
