/** A value and its spread, such as `102.0 cm ± 1.0`: where a column is narrow the spread goes on below. */
export function Measured({ text }: { text: string }) {
  const [value, spread] = text.split(' ± ');
  return (
    <span>
      <span className="number">{value}</span>
      {spread !== undefined && (
        <>
          {' '}
          <span className="number">± {spread}</span>
        </>
      )}
    </span>
  );
}
