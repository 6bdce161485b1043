// Dawn: refuses it: expected ';' for variable declaration
@fragment fn fs() {
    let a: i64 = 1li;
}
